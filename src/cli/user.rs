//! `user`: who may use a coordinator.

use clap::{Args, Subcommand};

use super::client::CoordinatorOption;
use super::exit_code::CliError;
use super::named::named;
use super::terminal;
use crate::api::members::{NewUser, UserPatch};
use crate::farm::access::scope::Role;
use crate::farm::access::user::UserName;

/// Say who may use a coordinator.
///
/// While there are no users, anyone who reaches it may do everything. The first user has to be an admin; from then on every request needs a token.
#[derive(Clone, Debug, Args)]
pub(super) struct User {
    #[command(subcommand)]
    task: Task,
}

#[derive(Clone, Debug, Subcommand)]
enum Task {
    /// List the users: name and role, separated by a tab.
    List {
        /// Print JSON.
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        coordinator: CoordinatorOption,
    },
    /// Add a user, and print a first token of theirs.
    Add {
        /// 1 to 64 small letters, digits, dots, dashes, underscores and @.
        name: UserName,
        /// A viewer looks, an artist submits jobs and changes their own, an admin does anything.
        #[arg(long, value_parser = named(Role::ALL, Role::name))]
        role: Role,
        /// Print JSON.
        #[arg(long)]
        json: bool,
        #[command(flatten)]
        coordinator: CoordinatorOption,
    },
    /// Give a user another role.
    Change {
        /// The user.
        name: UserName,
        /// What they are from now on.
        #[arg(long, value_parser = named(Role::ALL, Role::name))]
        role: Role,
        #[command(flatten)]
        coordinator: CoordinatorOption,
    },
    /// Delete a user with all tokens. Their jobs stay.
    Rm {
        /// The user.
        name: UserName,
        #[command(flatten)]
        coordinator: CoordinatorOption,
    },
}

impl User {
    pub(super) async fn run(self) -> Result<(), CliError> {
        match self.task {
            Task::List { json, coordinator } => {
                let users = coordinator.client()?.users().await?;
                if json {
                    return terminal::json(&users);
                }
                terminal::heads(&["NAME", "ROLE"])?;
                users.iter().try_for_each(|user| terminal::result(&format!("{}\t{}", user.name, user.role.name())))
            }
            Task::Add { name, role, json, coordinator } => {
                let added = coordinator.client()?.add_user(&NewUser { name, role }).await?;
                if json {
                    return terminal::json(&added);
                }
                let name = &added.user.name;
                terminal::note(&format!(
                    "this token is {name}'s; it is shown this once, and is as good as a password:"
                ));
                terminal::result(&added.token.secret)
            }
            Task::Change { name, role, coordinator } => {
                coordinator.client()?.change_user(name.as_str(), &UserPatch { role }).await?;
                Ok(())
            }
            Task::Rm { name, coordinator } => coordinator.client()?.delete_user(name.as_str()).await,
        }
    }
}
