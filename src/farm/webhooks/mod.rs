//! Programs that are told when a job changes its state, as Standard Webhooks (standardwebhooks.com, version 1.0.0) describe it: a signed POST, again
//! and again until it is taken.
//!
//! | file | what |
//! |---|---|
//! | [`webhook`] | an address, its secret, and a message on its way there |
//! | [`signature`] | by which the receiver knows who sends |
//! | [`sender`] | the requests |

pub(crate) mod sender;
pub mod signature;
pub(crate) mod webhook;
