//! Users and tokens.

use reqwest::Method;

use super::{CliError, Client, accepted, checked_name};
use crate::api::members::{AddedUser, IssuedToken, NewUser, TokenList, UserList, UserPatch};
use crate::farm::access::token::TokenView;
use crate::farm::access::user::User;
use crate::farm::coordinator::tokens::TokenRequest;

impl Client {
    pub(in crate::cli) async fn users(&self) -> Result<Vec<User>, CliError> {
        Ok(self.json::<UserList>(self.request(Method::GET, "/v1/users")).await?.users)
    }

    pub(in crate::cli) async fn add_user(&self, user: &NewUser) -> Result<AddedUser, CliError> {
        self.send_json(Method::POST, "/v1/users", user).await
    }

    pub(in crate::cli) async fn change_user(&self, name: &str, patch: &UserPatch) -> Result<User, CliError> {
        self.send_json(Method::PATCH, &format!("/v1/users/{name}"), patch).await
    }

    pub(in crate::cli) async fn delete_user(&self, name: &str) -> Result<(), CliError> {
        accepted(self.send(self.request(Method::DELETE, &format!("/v1/users/{name}"))).await?).await?;
        Ok(())
    }

    pub(in crate::cli) async fn tokens(&self) -> Result<Vec<TokenView>, CliError> {
        Ok(self.json::<TokenList>(self.request(Method::GET, "/v1/tokens")).await?.tokens)
    }

    pub(in crate::cli) async fn make_token(&self, wanted: &TokenRequest) -> Result<IssuedToken, CliError> {
        self.send_json(Method::POST, "/v1/tokens", wanted).await
    }

    pub(in crate::cli) async fn revoke_token(&self, id: &str) -> Result<(), CliError> {
        let path = format!("/v1/tokens/{}", checked_name(id, "a token's id; `photonfarm token list`")?);
        accepted(self.send(self.request(Method::DELETE, &path)).await?).await?;
        Ok(())
    }
}
