"""What is said about a result, decided once; `render` decides how it looks.

A report is sections of blocks: text, tables, strips and notices. Figures are rounded here and
nowhere else.
"""
