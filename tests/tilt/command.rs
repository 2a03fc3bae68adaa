//! Lens files, scene files and options that say how things stand.
