"""The server around the pages: what each answer says, how much visitors may take, how it ends."""
