"""The page's views, one file each."""
