"""What several robots do together: one file each, all of one shape (`protocol.Behaviour`)."""
