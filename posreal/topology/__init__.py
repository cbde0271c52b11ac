"""Networks as the unknown: every topology of up to N springs, dampers and inerters, each at its best values."""
