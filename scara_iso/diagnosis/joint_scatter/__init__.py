"""Scatter of several poses traced to the joints, and RP where nobody measured."""
