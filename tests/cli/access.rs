//! Users, tokens and encryption as people use them: by the command line alone.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Child, Command, Output, Stdio};
use std::thread::sleep;
use std::time::Duration;

use crate::command_line::{ended, failure, program, success, text};

const SCENE: &str = "tests/references/furnace-closed/scene.xml";

/// A coordinator of its own process that encrypts, and has one admin.
struct Coordinator {
    process: Child,
    url: String,
    fingerprint: String,
}

impl Coordinator {
    fn start(data: &Path, further: &[&str]) -> Self {
        let arguments = ["serve", "--listen", "127.0.0.1:0", "--tls", "auto", "--data", text(data)];
        let mut process = program(&[&arguments, further].concat()).stderr(Stdio::piped()).spawn().expect("it starts");
        let lines = BufReader::new(process.stderr.take().expect("a pipe")).lines();
        let (mut url, mut fingerprint) = (None, None);
        for line in lines.map_while(Result::ok) {
            url = line.strip_prefix("photonfarm listens at ").map(str::to_owned).or(url);
            fingerprint = line.strip_prefix("its certificate is ").map(str::to_owned);
            if fingerprint.is_some() {
                break;
            }
        }
        Self { process, url: url.expect("an address"), fingerprint: fingerprint.expect("a fingerprint") }
    }

    fn command(&self, token: &str, arguments: &[&str]) -> Command {
        let mut command = program(arguments);
        command.env("PHOTONFARM_URL", &self.url).env("PHOTONFARM_FINGERPRINT", &self.fingerprint);
        command.env("PHOTONFARM_TOKEN", token);
        command
    }

    fn run(&self, token: &str, arguments: &[&str]) -> Output {
        self.command(token, arguments).output().expect("it starts")
    }

    /// What a command that must succeed prints.
    fn printed(&self, token: &str, arguments: &[&str]) -> String {
        let output = self.run(token, arguments);
        ended(&output, 0);
        String::from_utf8(output.stdout).expect("text").trim().to_owned()
    }
}

impl Drop for Coordinator {
    fn drop(&mut self) {
        // It may have ended already.
        let _ = self.process.kill();
        let _ = self.process.wait();
    }
}

/// Nothing stands open by mistake, and whoever is refused is told what to do.
#[test]
fn a_coordinator_without_users_does_not_listen_to_other_machines() {
    let folder = tempfile::tempdir().expect("a folder");
    let refused = failure(&["serve", "--listen", "0.0.0.0:0", "--data", text(folder.path())], 2);
    assert!(refused.contains("store add-admin") && refused.contains("--insecure"), "{refused}");
    success(&["store", "check", "--data", text(folder.path())]);
    let file = folder.path().join("token");
    std::fs::write(&file, "short").expect("written");
    let arguments = ["serve", "--listen", "0.0.0.0:0", "--data", "none", "--admin-token-file", text(&file)];
    assert!(failure(&arguments, 3).contains("holds no token"));
}

#[test]
fn two_users_render_with_a_worker_that_joined_by_token() {
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("data");
    let added = program(&["store", "add-admin", "anna", "--data", text(&data)]).output().expect("it starts");
    ended(&added, 0);
    let anna = String::from_utf8(added.stdout).expect("text").trim().to_owned();
    let coordinator = Coordinator::start(&data, &[]);
    assert!(ended(&coordinator.run("", &["jobs"]), 1).contains("PHOTONFARM_TOKEN"));
    let ben = coordinator.printed(&anna, &["user", "add", "ben", "--role", "artist"]);
    assert_eq!(coordinator.printed(&anna, &["user", "list"]), "anna\tadmin\nben\tartist");
    assert!(ended(&coordinator.run(&ben, &["user", "add", "cora", "--role", "viewer"]), 1).contains("scope admin"));

    let join = coordinator.printed(&anna, &["token", "new", "--scope", "worker", "--label", "the rack"]);
    let token_file = folder.path().join("join");
    std::fs::write(&token_file, format!("{join}\n")).expect("written");
    let arguments = ["worker", "--threads", "1", "--name", "rack-1", "--token-file", text(&token_file)];
    let mut worker = coordinator.command("", &arguments).stderr(Stdio::null()).spawn().expect("it starts");
    assert!(ended(&coordinator.run(&ben, &["worker", "--threads", "1"]), 4).contains("scope worker"));

    let own = coordinator.printed(&ben, &["submit", SCENE, "--passes", "4", "--method", "sppm"]);
    let annas = coordinator.printed(&anna, &["submit", SCENE, "--passes", "1000000", "--method", "sppm"]);
    coordinator.printed(&ben, &["watch", &own]);
    let refused = ended(&coordinator.run(&ben, &["cancel", &annas]), 1);
    assert!(refused.contains("belongs to anna"), "{refused}");
    coordinator.printed(&anna, &["cancel", &annas]);
    assert!(coordinator.printed(&ben, &["jobs", "--owner", "ben"]).starts_with(&own));
    let picture = folder.path().join("picture.exr");
    coordinator.printed(&ben, &["fetch", &own, "-o", text(&picture)]);
    assert!(picture.exists());

    let tokens = coordinator.printed(&anna, &["token", "list"]);
    let rack = tokens.lines().find(|line| line.ends_with("the rack")).expect("it is listed");
    coordinator.printed(&anna, &["token", "rm", rack.split('\t').next().expect("an id")]);
    assert_eq!(worker.wait().expect("it ends").code(), Some(4), "a worker whose token is revoked ends");
    // The worker may hear of it before the journal has it.
    let revoked = "of nobody was revoked by anna";
    let mut journal = coordinator.printed(&ben, &["journal"]);
    for _ in 0..100 {
        if journal.contains(revoked) {
            break;
        }
        sleep(Duration::from_millis(100));
        journal = coordinator.printed(&ben, &["journal"]);
    }
    for deed in ["user ben was added as artist by anna", "of nobody was made by anna", revoked, "is cancelled"] {
        assert!(journal.lines().any(|line| line.starts_with("20") && line.contains(deed)), "{deed}: {journal}");
    }
    let mut wrong = coordinator.command(&anna, &["jobs"]);
    wrong.env("PHOTONFARM_FINGERPRINT", format!("sha256:{}", "0".repeat(64)));
    ended(&wrong.output().expect("it starts"), 4);
}

/// As containers are set up: with secrets in files, and no step before.
#[test]
fn an_admin_can_be_given_at_start() {
    let folder = tempfile::tempdir().expect("a folder");
    let (admin, worker) = ("a".repeat(40), "w".repeat(40));
    let (admin_file, worker_file) = (folder.path().join("admin"), folder.path().join("worker"));
    std::fs::write(&admin_file, format!("{admin}\n")).expect("written");
    std::fs::write(&worker_file, &worker).expect("written");
    let data = folder.path().join("data");
    let further =
        ["--admin-token-file", text(&admin_file), "--worker-token-file", text(&worker_file), "--workers", "1"];
    let coordinator = Coordinator::start(&data, &further);
    assert_eq!(coordinator.printed(&admin, &["user", "list"]), "operator\tadmin");
    let further = coordinator.printed(&admin, &["token", "new", "--scope", "read"]);
    coordinator.printed(&further, &["jobs"]);
    let job = coordinator.printed(&admin, &["submit", SCENE, "--passes", "1", "--method", "sppm"]);
    coordinator.printed(&admin, &["watch", &job]);
    assert!(ended(&coordinator.run(&worker, &["jobs"]), 1).contains("scope read"));
}
