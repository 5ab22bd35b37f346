"""Sheets: what is printed for a capture, as PDF in true size; `kinds` lists all."""
