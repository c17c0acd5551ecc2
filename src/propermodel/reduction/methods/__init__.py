"""Methods of others to find a proper model, behind one interface, to compare with: one module each."""
