//! Pure mathematics against the oracles of the papers and against properties.
