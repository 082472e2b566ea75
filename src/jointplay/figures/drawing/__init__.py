"""Elements, styles and axes that figures share."""
