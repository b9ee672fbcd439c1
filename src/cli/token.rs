//! `token`: by what users and workers are known.

use clap::{Args, Subcommand};

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::named::named;
use super::terminal;
use crate::farm::access::scope::Scope;
use crate::farm::access::token::TokenView;
use crate::farm::access::user::UserName;
use crate::farm::coordinator::tokens::TokenRequest;

/// Make, list and revoke the tokens by which users and workers are known.
#[derive(Clone, Debug, Args)]
pub(super) struct Token {
    #[command(subcommand)]
    task: Task,
}

#[derive(Clone, Debug, Subcommand)]
enum Task {
    /// List your tokens, an admin all: id, scope, user, when it was made, when it ends, label, separated by tabs.
    List {
        /// Print JSON.
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        coordinator: CoordinatorOption,
    },
    /// Make a token and print it.
    New {
        /// What it allows [default: what the user's role allows]. With `worker`, workers join by it, and it is nobody's.
        #[arg(long, value_parser = named(Scope::ALL, Scope::name))]
        scope: Option<Scope>,
        /// Whose it is [default: yours].
        #[arg(long)]
        user: Option<UserName>,
        /// What it is for.
        #[arg(long, default_value = "")]
        label: String,
        /// Days after which it is not taken any more [default: never].
        #[arg(long, value_parser = clap::value_parser!(u16).range(1..=3650))]
        days: Option<u16>,
        /// Print JSON.
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        coordinator: CoordinatorOption,
    },
    /// Revoke a token. Pages that were logged in with it are logged out, workers that joined by it get no more work.
    Rm {
        /// Its id.
        id: String,
        #[command(flatten)]
        coordinator: CoordinatorOption,
    },
}

impl Token {
    pub(super) async fn run(self) -> Result<(), CliError> {
        match self.task {
            Task::List { json, coordinator } => {
                let tokens = coordinator.client()?.tokens().await?;
                if json {
                    return terminal::json(&tokens);
                }
                terminal::heads(&["ID", "SCOPE", "USER", "CREATED", "EXPIRES", "LABEL"])?;
                tokens.iter().try_for_each(|token| terminal::result(&line(token)))
            }
            Task::New { scope, user, label, days, json, coordinator } => {
                let wanted = TokenRequest { user, label, scope, days };
                let made = coordinator.client()?.make_token(&wanted).await?;
                if json { terminal::json(&made) } else { terminal::result(&made.secret) }
            }
            Task::Rm { id, coordinator } => coordinator.client()?.revoke_token(&id).await,
        }
    }
}

fn line(token: &TokenView) -> String {
    let user = token.user.as_ref().map_or("-", UserName::as_str);
    let created = terminal::moment(token.created);
    let expires = token.expires.map_or_else(|| "-".to_owned(), terminal::moment);
    format!("{}\t{}\t{user}\t{created}\t{expires}\t{}", token.id, token.scope.name(), token.label)
}
