//! Who may do what: users with roles, tokens with scopes, and the secrets of workers.
//!
//! While there is no user, anyone who reaches the coordinator may do everything. With the first user, every request needs a token.
//!
//! | file | what |
//! |---|---|
//! | [`scope`] | what a token allows, and what a role allows at most |
//! | [`user`] | names of users |
//! | [`secret`] | texts that nobody can guess, and the hashes that are kept of them |
//! | [`token`] | what is known of a token |
//! | [`caller`] | who sent a request, and what follows |
//! | [`register`] | all users and tokens, in memory |
//! | [`worker_secret`] | what a worker shows after it joined |

pub mod caller;
pub mod register;
pub mod scope;
pub mod secret;
pub mod token;
pub mod user;
pub mod worker_secret;
