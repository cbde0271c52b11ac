"""Vehicles in time, with devices whose elements rub, have play and end: a linear plant and networks that are not."""
