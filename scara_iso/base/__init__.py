"""What every room stands on, and nothing of the trade: errors, units, files and disk, plug-ins."""
