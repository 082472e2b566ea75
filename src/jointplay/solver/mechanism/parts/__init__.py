"""Parts of a mechanism: records of links, joints, laws, springs, loads and drives."""
