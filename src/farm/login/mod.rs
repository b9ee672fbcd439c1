//! Logging in to the page with the account that people have elsewhere: OpenID Connect, the authorization code flow with PKCE (OpenID Connect Core
//! 1.0, section 3.1; RFC 7636). The provider says who somebody is; what they may do stays with the users of this farm.
//!
//! | file | what |
//! |---|---|
//! | [`options`] | which provider, and who its people are here |
//! | [`provider`] | the two steps: send a browser there, and read what it brings back |
//! | `pending` | browsers that were sent there and are not back yet |
//! | `requests` | requests to the provider |

pub(crate) mod options;
mod pending;
pub(crate) mod provider;
mod requests;
