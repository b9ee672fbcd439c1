//! One file per format, all into the same description.
