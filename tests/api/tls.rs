//! Encrypted farms: whom clients trust, and whom a coordinator lets in.

use std::fs;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

use crate::http_client::http_client;
use photonfarm::api;
use photonfarm::farm::LocalFarm;
use photonfarm::farm::dial::Dialer;
use photonfarm::farm::job::{JobRequest, StopRule};
use photonfarm::farm::prepared_scenes::PreparedScenes;
use photonfarm::farm::tls::client::{Trust, configure};
use photonfarm::farm::tls::files::IdentityFiles;
use photonfarm::farm::tls::fingerprint::Fingerprint;
use photonfarm::farm::tls::server::ServerTls;
use photonfarm::farm::worker::{WorkerOptions, run_worker};
use rcgen::{BasicConstraints, CertificateParams, CertifiedIssuer, IsCa, KeyPair};
use tokio_util::sync::CancellationToken;

const SCENE: &[u8] = include_bytes!("../references/furnace-closed/scene.xml");

async fn farm(workers: usize, tls: Option<ServerTls>) -> LocalFarm {
    let routes = |coordinator, shutdown| api::router(api::ApiState { coordinator, shutdown });
    LocalFarm::builder().workers(workers).tls(tls).routes(routes).start().await.expect("a farm")
}

fn automatic() -> ServerTls {
    ServerTls::automatic(None, &["localhost".to_owned()], None).expect("a certificate")
}

/// Asks as a client with this trust; the status, or nothing where no connection came about.
async fn ask(url: &str, trust: &Trust, identity: Option<&IdentityFiles>) -> Option<u16> {
    let settings = configure(trust, identity).expect("settings");
    let client = reqwest::Client::builder().no_proxy().tls_backend_preconfigured(settings).build().expect("a client");
    client.get(format!("{url}/healthz")).send().await.ok().map(|response| response.status().as_u16())
}

fn wrong(fingerprint: Fingerprint) -> Fingerprint {
    let text = fingerprint.to_string();
    let last = if text.ends_with('0') { "1" } else { "0" };
    format!("{}{last}", &text[..text.len() - 1]).parse().expect("a fingerprint")
}

async fn bits(farm: &LocalFarm) -> Vec<u32> {
    let scene = farm.client().add_scene(SCENE.to_vec()).await.expect("a scene").hash;
    let stop = StopRule { passes: Some(6), ..StopRule::default() };
    let job = farm.client().submit(JobRequest { stop, ..JobRequest::of_scene(scene) }).await.expect("a job");
    let mut status = farm.client().watch(job).expect("it is there");
    status.wait_for(|status| status.state.is_final()).await.expect("it ends");
    let (picture, _) = farm.client().picture(job).await.expect("a picture");
    picture.radiance.iter().flatten().map(|value| value.to_bits()).collect()
}

#[tokio::test(flavor = "multi_thread")]
async fn an_encrypted_farm_renders_the_same_bits() {
    let encrypted = farm(2, Some(automatic())).await;
    assert!(encrypted.url().starts_with("https://"));
    assert_eq!(bits(&encrypted).await, bits(&farm(1, None).await).await);
}

#[tokio::test(flavor = "multi_thread")]
async fn clients_trust_the_certificate_that_they_were_told_and_no_other() {
    let tls = automatic();
    let fingerprint = tls.fingerprint();
    let farm = farm(0, Some(tls)).await;
    let url = farm.url();
    assert_eq!(ask(&url, &Trust::Pinned(fingerprint), None).await, Some(200));
    assert_eq!(ask(&url, &Trust::Pinned(wrong(fingerprint)), None).await, None);
    assert_eq!(ask(&url, &Trust::System, None).await, None);
    let plain = http_client(Duration::from_secs(10)).get(url.replace("https", "http")).send().await;
    assert!(plain.is_err(), "an encrypted port answers nobody who does not encrypt");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_worker_joins_the_coordinator_that_it_trusts() {
    let tls = automatic();
    let fingerprint = tls.fingerprint();
    let farm = farm(0, Some(tls)).await;
    let stop = CancellationToken::new();
    for (name, trusted) in [("trusting", fingerprint), ("suspicious", wrong(fingerprint))] {
        let settings = configure(&Trust::Pinned(trusted), None).expect("settings");
        let options = WorkerOptions {
            coordinator: farm.url(),
            name: name.to_owned(),
            threads: 1,
            token: None,
            scenes: PreparedScenes::new(1),
            dialer: Dialer::tcp(Some(Arc::new(settings))),
        };
        tokio::spawn(run_worker(options, stop.clone()));
    }
    while farm.client().workers().is_empty() {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    tokio::time::sleep(Duration::from_millis(500)).await;
    let names: Vec<String> = farm.client().workers().into_iter().map(|worker| worker.name).collect();
    assert_eq!(names, ["trusting"]);
    stop.cancel();
}

#[test]
fn a_certificate_that_is_made_here_stays_and_its_key_is_private() {
    let folder = tempfile::tempdir().expect("a folder");
    let place = folder.path().join("tls");
    let names = ["coordinator.example".to_owned(), "10.0.0.1".to_owned()];
    let made = || ServerTls::automatic(Some(&place), &names, None).expect("a certificate").fingerprint();
    let fingerprint = made();
    assert_eq!(made(), fingerprint);
    let key = fs::metadata(place.join("key.pem")).expect("a key").permissions();
    assert_eq!(std::os::unix::fs::PermissionsExt::mode(&key) & 0o777, 0o600);
    fs::write(place.join("key.pem"), "no key").expect("written");
    let refused = ServerTls::automatic(Some(&place), &names, None).err().expect("refused").to_string();
    assert!(refused.contains("key.pem"), "{refused}");
}

/// An authority, and what it signs.
struct Authority(CertifiedIssuer<'static, KeyPair>);

impl Authority {
    fn new() -> Self {
        let mut parameters = CertificateParams::new(Vec::new()).expect("parameters");
        parameters.is_ca = IsCa::Ca(BasicConstraints::Unconstrained);
        Self(CertifiedIssuer::self_signed(parameters, KeyPair::generate().expect("a key")).expect("an authority"))
    }

    fn write(&self, file: &Path) {
        fs::write(file, self.0.pem()).expect("written");
    }

    fn sign(&self, name: &str, folder: &Path) -> IdentityFiles {
        let files = IdentityFiles {
            certificate: folder.join(format!("{name}.pem")),
            key: folder.join(format!("{name}-key.pem")),
        };
        let key = KeyPair::generate().expect("a key");
        let parameters = CertificateParams::new(vec![name.to_owned()]).expect("parameters");
        let certificate = parameters.signed_by(&key, &self.0).expect("a certificate");
        fs::write(&files.certificate, certificate.pem()).expect("written");
        fs::write(&files.key, key.serialize_pem()).expect("written");
        files
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn certificates_of_authorities_are_checked_on_both_sides() {
    let folder = tempfile::tempdir().expect("a folder");
    let (ours, others) = (Authority::new(), Authority::new());
    let (our_file, other_file) = (folder.path().join("ours.pem"), folder.path().join("others.pem"));
    ours.write(&our_file);
    others.write(&other_file);
    let server = ours.sign("127.0.0.1", folder.path());
    let tls = ServerTls::from_files(&server, Some(&our_file)).expect("a certificate");
    let farm = farm(0, Some(tls)).await;
    let trust = Trust::Authorities(our_file);
    let (client, stranger) = (ours.sign("client", folder.path()), others.sign("stranger", folder.path()));
    let url = farm.url();
    assert_eq!(ask(&url, &trust, Some(&client)).await, Some(200));
    assert_eq!(ask(&url, &trust, None).await, None, "a client without a certificate");
    assert_eq!(ask(&url, &trust, Some(&stranger)).await, None, "a client of another authority");
    assert_eq!(
        ask(&url, &Trust::Authorities(other_file), Some(&client)).await,
        None,
        "a coordinator of another authority"
    );
    let elsewhere = url.replace("127.0.0.1", "localhost");
    assert_eq!(ask(&elsewhere, &trust, Some(&client)).await, None, "a certificate for another name");
}
