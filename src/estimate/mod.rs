//! Tallies, the rules that merge them into an estimate, and the picture read from it.
