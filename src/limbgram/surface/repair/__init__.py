"""Repair: one piece, no hole but the brim."""
