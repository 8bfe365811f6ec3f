"""Before a test: how small an effect it will show, and which poses tell joints apart."""
