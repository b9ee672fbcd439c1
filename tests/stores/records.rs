//! The store through its public door: a real SQLite file always, a real PostgreSQL database and a real S3-compatible bucket where the
//! environment names them (`PHOTONFARM_TEST_POSTGRES`, `PHOTONFARM_TEST_S3` with the usual `AWS_…` variables).

use std::path::Path;

use photonfarm::farm::access::scope::{Role, Scope};
use photonfarm::farm::access::secret::SecretHash;
use photonfarm::farm::access::token::Token;
use photonfarm::farm::access::user::{User, UserName};
use photonfarm::farm::ids::{JobId, SequenceId};
use photonfarm::farm::job::JobState;
use photonfarm::farm::store::jobs::{JobRow, Snapshots};
use photonfarm::farm::store::journal::JournalRow;
use photonfarm::farm::store::scenes::SceneRow;
use photonfarm::farm::store::sequences::SequenceRow;
use photonfarm::farm::store::{BlobName, BlobsLocation, RecordsLocation, Store, StoreError, StoreLocation};

use crate::ONE_AT_A_TIME;

/// Every kind of store that there is here, empty.
fn locations(folder: &Path) -> Vec<StoreLocation> {
    let mut locations = vec![StoreLocation::folder(folder)];
    match std::env::var("PHOTONFARM_TEST_POSTGRES") {
        Ok(address) => locations.push(StoreLocation {
            records: RecordsLocation::Postgres(address),
            folder: folder.join("postgres"),
            blobs: BlobsLocation::Folder(folder.join("postgres/blobs")),
        }),
        Err(_) => println!("PHOTONFARM_TEST_POSTGRES is not set: no PostgreSQL is tested"),
    }
    match std::env::var("PHOTONFARM_TEST_S3") {
        Ok(address) => locations.push(StoreLocation {
            blobs: BlobsLocation::S3(format!("{address}/{}", folder.file_name().expect("a name").to_string_lossy())),
            ..StoreLocation::folder(folder.join("s3"))
        }),
        Err(_) => println!("PHOTONFARM_TEST_S3 is not set: no S3-compatible store is tested"),
    }
    locations
}

fn scene(hash: &str) -> SceneRow {
    SceneRow { hash: hash.to_owned(), bytes: 5, created: 1, record: "{\"a\":1}".to_owned() }
}

fn job(id: JobId, scene: &str) -> JobRow {
    JobRow {
        id,
        state: JobState::Queued,
        scene: scene.to_owned(),
        created: 2,
        ended: None,
        record: "{\"é\":[1,2]}".to_owned(),
        snapshots: Snapshots::default(),
    }
}

fn sequence(number: u64, record: &str) -> SequenceRow {
    SequenceRow { id: SequenceId::new(JobId::new(number)), created: 4, record: record.to_owned() }
}

/// Opens a store when the term of whoever led before is over.
pub(crate) async fn open(location: &StoreLocation) -> Store {
    for _ in 0..150 {
        match Store::open(location).await {
            Err(StoreError::InUse { .. }) => tokio::time::sleep(std::time::Duration::from_millis(100)).await,
            opened => return opened.expect("a store"),
        }
    }
    panic!("a term ends when nobody prolongs it")
}

pub(crate) async fn empty(store: &Store) {
    for user in store.users().await.expect("users") {
        store.delete_user(&user.name).await.expect("deleted");
    }
    for token in store.valid_tokens(0).await.expect("tokens") {
        store.delete_token(&token.hash).await.expect("deleted");
    }
    for row in store.job_rows().await.expect("rows") {
        store.delete_job(row.id).await.expect("deleted");
    }
    for row in store.sequence_rows().await.expect("rows") {
        store.delete_sequence(row.id).await.expect("deleted");
    }
    for row in store.scene_rows().await.expect("rows") {
        store.delete_scene(&row.hash).await.expect("deleted");
    }
}

#[tokio::test]
async fn records_are_there_when_a_store_is_opened_again() {
    let _turn = ONE_AT_A_TIME.lock().await;
    let folder = tempfile::tempdir().expect("a folder");
    for location in locations(folder.path()) {
        let store = open(&location).await;
        empty(&store).await;
        let epoch = store.epoch();
        assert!(matches!(Store::open(&location).await, Err(StoreError::InUse { .. })), "one coordinator at a time");
        store.insert_scene(&scene("aa")).await.expect("inserted");
        store.insert_scene(&scene("aa")).await.expect("the same again is nothing new");
        let first = JobId::after(store.last_job().await.expect("read"), 0);
        let mut rows: Vec<JobRow> = (0..3).map(|index| job(JobId::new(first.number() + index), "aa")).collect();
        for row in &rows {
            store.insert_job(row).await.expect("inserted");
        }
        rows[1].state = JobState::Paused;
        rows[2].state = JobState::Done;
        rows[2].ended = Some(77);
        let name = BlobName::of_snapshot(rows[2].id, 5, b"state");
        rows[2].snapshots = Snapshots { newest: Some(name.clone()), earlier: None, resume: Some(name) };
        store.update_job(&rows[1]).await.expect("updated");
        store.update_job(&rows[2]).await.expect("updated");
        assert!(store.delete_scene("aa").await.is_err(), "a job refers to it");
        let line =
            |text: &str| JournalRow { sequence: 0, time: 3, job: Some(first), worker: None, text: text.to_owned() };
        store.append_journal(&[line("one"), line("two")]).await.expect("appended");
        store.record_worker("w", 2, 10).await.expect("recorded");
        let sequences = [5, 6].map(|number| sequence(number, "{\"made\":0}"));
        for row in &sequences {
            store.put_sequence(row).await.expect("inserted");
        }
        let further = sequence(5, "{\"made\":1}");
        store.put_sequence(&further).await.expect("updated");
        store.delete_sequence(sequences[1].id).await.expect("deleted");
        store.close().await;
        drop(store);

        let store = Store::open(&location).await.expect("the same store");
        assert_eq!(store.epoch(), epoch + 1);
        assert_eq!(store.job_rows().await.expect("rows"), rows);
        assert_eq!(store.job_row(first).await.expect("a row"), Some(rows[0].clone()));
        assert_eq!(store.scene_rows().await.expect("rows"), [scene("aa")]);
        assert_eq!(store.sequence_rows().await.expect("rows"), [further]);
        let lines = store.journal(0, Some(first), 100).await.expect("lines");
        let texts: Vec<&str> = lines.iter().rev().take(2).map(|row| row.text.as_str()).collect();
        assert_eq!(texts, ["two", "one"]);
        assert!(store.journal(lines.last().expect("lines").sequence, None, 100).await.expect("lines").is_empty());
        store.close().await;
    }
}

#[tokio::test]
async fn a_damaged_or_emptied_database_is_refused_at_once() {
    let folder = tempfile::tempdir().expect("a folder");
    let location = StoreLocation::folder(folder.path());
    let store = Store::open(&location).await.expect("a store");
    let name = BlobName::of_snapshot(JobId::new(1), 5, b"state");
    store.blobs().put(&name, b"state".to_vec()).await.expect("stored");
    store.close().await;
    drop(store);
    let RecordsLocation::Sqlite(file) = &location.records else { panic!("an SQLite store") };
    let good = std::fs::read(file).expect("a file");
    for (damage, words) in
        [(vec![7; 8192], "damaged"), (good[..good.len() / 2].to_vec(), "damaged"), (Vec::new(), "no record")]
    {
        std::fs::write(file, damage).expect("written");
        let start = std::time::Instant::now();
        let problem = Store::open(&location).await.err().expect("it is refused").to_string();
        assert!(problem.contains(words), "{problem}");
        assert!(start.elapsed().as_secs() < 10, "nobody waits for what does not get better");
    }
    std::fs::write(file, good).expect("written");
    let store = Store::open(&location).await.expect("it was not touched");
    assert!(store.blobs().get(&name).await.is_ok());
}

#[tokio::test]
async fn nothing_stays_of_uploads_that_were_broken_off_by_a_kill() {
    let folder = tempfile::tempdir().expect("a folder");
    let location = StoreLocation::folder(folder.path());
    let store = Store::open(&location).await.expect("a store");
    let mut upload = store.blobs().begin_scene().await.expect("begun");
    upload.write(&vec![1; 20 << 20]).await.expect("written");
    // As if the process was killed: nothing is tidied up.
    std::mem::forget(upload);
    let uploads = folder.path().join("blobs/uploads");
    assert!(std::fs::read_dir(&uploads).expect("a folder").next().is_some());
    store.close().await;
    drop(store);
    let _store = Store::open(&location).await.expect("the same store");
    assert!(!uploads.exists());
}

#[tokio::test]
async fn ids_of_deleted_jobs_are_not_used_again() {
    let _turn = ONE_AT_A_TIME.lock().await;
    let folder = tempfile::tempdir().expect("a folder");
    for location in locations(folder.path()) {
        let store = open(&location).await;
        empty(&store).await;
        store.insert_scene(&scene("aa")).await.expect("inserted");
        let id = JobId::after(store.last_job().await.expect("read"), 1_800_000_000_000);
        store.insert_job(&job(id, "aa")).await.expect("inserted");
        store.delete_job(id).await.expect("deleted");
        store.close().await;
        drop(store);
        let store = Store::open(&location).await.expect("the same store");
        // The clock went back.
        assert!(JobId::after(store.last_job().await.expect("read"), 0) > id);
        store.close().await;
    }
}

#[tokio::test]
async fn blobs_are_whole_or_not_there() {
    let _turn = ONE_AT_A_TIME.lock().await;
    let folder = tempfile::tempdir().expect("a folder");
    for location in locations(folder.path()) {
        let store = open(&location).await;
        let blobs = store.blobs();
        let bytes: Vec<u8> = (0..9_000_000u32).map(|index| (index / 7) as u8).collect();
        let mut upload = blobs.begin_scene().await.expect("begun");
        for part in bytes.chunks(70_001) {
            upload.write(part).await.expect("written");
        }
        assert_eq!(upload.bytes(), bytes.len() as u64);
        let uploaded = upload.finish().await.expect("finished");
        uploaded.keep().await.expect("kept");
        assert_eq!(uploaded.hash, blake3::hash(&bytes).to_hex().to_string());
        let name = BlobName::of_scene(&uploaded.hash);
        assert!(blobs.get(&name).await.expect("there") == bytes);

        let mut torn = blobs.begin_scene().await.expect("begun");
        torn.write(&bytes[..100]).await.expect("written");
        torn.abort().await.expect("aborted");
        let snapshot = BlobName::of_snapshot(JobId::new(3), 17, b"state");
        blobs.put(&snapshot, b"state".to_vec()).await.expect("put");
        let names: Vec<BlobName> = blobs.list().await.expect("listed").into_iter().map(|entry| entry.name).collect();
        assert_eq!(names, [name.clone(), snapshot.clone()], "nothing of the torn upload is left");

        let wrong = BlobName::of_snapshot(JobId::new(3), 18, b"other bytes");
        blobs.put(&wrong, b"state".to_vec()).await.expect("put");
        assert!(matches!(blobs.get(&wrong).await, Err(StoreError::Damaged { .. })));
        for name in [name, snapshot, wrong] {
            blobs.delete(&name).await.expect("deleted");
            blobs.delete(&name).await.expect("deleting twice is deleting once");
        }
        assert_eq!(blobs.list().await.expect("listed"), []);
        store.close().await;
    }
}

#[tokio::test]
async fn a_check_finds_what_is_missing_and_a_clean_up_what_is_too_much() {
    let folder = tempfile::tempdir().expect("a folder");
    let store = Store::open(&StoreLocation::folder(folder.path())).await.expect("a store");
    let mut upload = store.blobs().begin_scene().await.expect("begun");
    upload.write(b"a scene").await.expect("written");
    let uploaded = upload.finish().await.expect("finished");
    uploaded.keep().await.expect("kept");
    let hash = uploaded.hash;
    store.insert_scene(&scene(&hash)).await.expect("inserted");
    let id = JobId::after(None, 1_800_000_000_000);
    let lost = BlobName::of_snapshot(id, 1, b"lost");
    let row = JobRow { snapshots: Snapshots { newest: Some(lost), ..Snapshots::default() }, ..job(id, &hash) };
    store.insert_job(&row).await.expect("inserted");
    let orphan = BlobName::of_snapshot(id, 9, b"nobody's");
    store.blobs().put(&orphan, b"nobody's".to_vec()).await.expect("put");

    let report = store.check().await.expect("a report");
    assert_eq!((report.scenes, report.jobs, report.orphans, report.problems.len()), (1, 1, 1, 1), "{report:?}");
    assert_eq!(store.clean_up().await.expect("a report").blobs, 1);
    assert_eq!(store.clean_up().await.expect("a report").blobs, 0);

    store.update_job(&job(id, &hash)).await.expect("updated");
    let file = folder.path().join("all.zip");
    store.export(&file).await.expect("exported");
    let mut archive = zip::ZipArchive::new(std::fs::File::open(file).expect("a file")).expect("an archive");
    let names: Vec<String> = archive.file_names().map(|name| name.expect("text").into_owned()).collect();
    assert!(names.contains(&format!("blobs/scenes/{hash}")) && names.contains(&"jobs.jsonl".to_owned()), "{names:?}");
    let lines = std::io::read_to_string(archive.by_name("jobs.jsonl").expect("there")).expect("text");
    assert!(lines.contains(&id.to_string()), "{lines}");
}

/// Tokens end with their user, with the token that they came from, and at their time.
#[tokio::test]
async fn users_and_tokens_are_kept_and_end() {
    let _turn = ONE_AT_A_TIME.lock().await;
    let folder = tempfile::tempdir().expect("a folder");
    for location in locations(folder.path()) {
        let store = open(&location).await;
        empty(&store).await;
        let name: UserName = "anna".parse().expect("a name");
        let user = User { name: name.clone(), role: Role::Artist, created: 5 };
        store.put_user(&user).await.expect("stored");
        store.put_user(&User { role: Role::Admin, created: 9, ..user.clone() }).await.expect("changed");
        assert_eq!(store.users().await.expect("users"), [User { role: Role::Admin, ..user }]);
        let token = |text: &str, user: Option<&UserName>, expires, parent| Token {
            hash: SecretHash::of(text),
            user: user.cloned(),
            label: "é".to_owned(),
            scope: Scope::Submit,
            created: 6,
            expires,
            parent,
        };
        let first = token("first", Some(&name), None, None);
        let page = token("page", Some(&name), Some(100), Some(first.hash));
        let short = token("short", Some(&name), Some(50), None);
        let join = Token { scope: Scope::Worker, ..token("join", None, None, None) };
        for token in [&first, &page, &short, &join] {
            store.insert_token(token).await.expect("stored");
        }
        let valid = async |now| {
            let tokens = store.valid_tokens(now).await.expect("tokens");
            let mut labels: Vec<_> = tokens.into_iter().map(|token| (token.scope.name(), token.expires)).collect();
            labels.sort_unstable();
            labels
        };
        assert_eq!(valid(49).await.len(), 4);
        assert_eq!(valid(50).await, [("submit", None), ("submit", Some(100)), ("worker", None)]);
        store.delete_token(&first.hash).await.expect("deleted");
        assert_eq!(valid(50).await, [("worker", None)], "the page was logged in with the first");
        store.insert_token(&first).await.expect("stored again");
        store.delete_user(&name).await.expect("deleted");
        assert_eq!(valid(50).await, [("worker", None)], "the user's are gone");
        store.close().await;
    }
}

/// A program does not touch what a newer one wrote.
#[tokio::test]
async fn a_newer_store_is_refused_unharmed() {
    let folder = tempfile::tempdir().expect("a folder");
    let location = StoreLocation::folder(folder.path());
    Store::open(&location).await.expect("a store").close().await;
    let file = folder.path().join("photonfarm.sqlite");
    sqlx::any::install_default_drivers();
    let pool = sqlx::AnyPool::connect(&format!("sqlite://{}", file.display())).await.expect("the same file");
    sqlx::query("UPDATE meta SET value = 99 WHERE name = 'version'").execute(&pool).await.expect("updated");
    pool.close().await;
    let before = std::fs::read(&file).expect("a file");
    let refused = Store::open(&location).await.err().expect("refused");
    assert!(matches!(refused, StoreError::Newer { found: 99, .. }), "{refused}");
    assert!(std::fs::read(&file).expect("a file") == before, "not a byte is changed");
}

/// One file of every version that was released is kept, and opens.
#[tokio::test]
async fn stores_of_earlier_versions_open() {
    let released = Path::new("tests/stores/released");
    let mut versions = 0;
    for entry in std::fs::read_dir(released).expect("the folder of released versions") {
        let file = entry.expect("an entry").path();
        let folder = tempfile::tempdir().expect("a folder");
        std::fs::copy(&file, folder.path().join("photonfarm.sqlite")).expect("copied");
        let store = Store::open(&StoreLocation::folder(folder.path())).await.expect("it opens");
        assert_eq!(store.job_rows().await.expect("rows").len(), 1, "{}", file.display());
        let users = if file.ends_with("version-1.sqlite") { 0 } else { 2 };
        assert_eq!(store.users().await.expect("users").len(), users, "{}", file.display());
        let sequences = usize::from(file.ends_with("version-4.sqlite"));
        assert_eq!(store.sequence_rows().await.expect("rows").len(), sequences, "{}", file.display());
        versions += 1;
        assert!(store.version().await.expect("a version") >= versions);
    }
    assert!(versions > 0);
}

#[tokio::test]
async fn a_folder_that_cannot_be_written_is_told() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("file");
    std::fs::write(&file, "not a folder").expect("written");
    let refused = Store::open(&StoreLocation::folder(file.join("below"))).await.err().expect("refused");
    assert!(matches!(refused, StoreError::Open { .. }), "{refused}");
}

/// A database that restarts costs a retry, no more.
#[tokio::test]
async fn a_database_that_restarts_is_waited_for() {
    let _turn = ONE_AT_A_TIME.lock().await;
    let environment = |name: &str| std::env::var(name).ok();
    let (Some(address), Some(restart)) =
        (environment("PHOTONFARM_TEST_POSTGRES"), environment("PHOTONFARM_TEST_POSTGRES_RESTART"))
    else {
        println!("PHOTONFARM_TEST_POSTGRES_RESTART is not set: no restart is tested");
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let location =
        StoreLocation { records: RecordsLocation::Postgres(address), ..StoreLocation::folder(folder.path()) };
    let store = open(&location).await;
    let elsewhere = StoreLocation { folder: folder.path().join("elsewhere"), ..location.clone() };
    let second = Store::open(&elsewhere).await.err();
    assert!(matches!(second, Some(StoreError::InUse { .. })), "one coordinator at a time uses a database: {second:?}");
    store.insert_scene(&scene("bb")).await.expect("inserted");
    let status = std::process::Command::new("bash").args(["-c", &restart]).stdout(std::process::Stdio::null()).status();
    assert!(status.expect("bash").success());
    let id = JobId::after(store.last_job().await.ok().flatten(), 1_900_000_000_000);
    let mut attempts = 0;
    while let Err(problem) = store.insert_job(&job(id, "bb")).await {
        assert!(problem.is_temporary(), "{problem:?}");
        attempts += 1;
        assert!(attempts < 10, "it never comes back: {problem}");
        tokio::time::sleep(std::time::Duration::from_millis(200)).await;
    }
    assert!(store.job_row(id).await.expect("a row").is_some());
    store.delete_job(id).await.expect("deleted");
    store.close().await;
}

/// A coordinator that was thought dead changes nothing any more.
#[tokio::test]
async fn who_does_not_lead_any_more_cannot_write() {
    let _turn = ONE_AT_A_TIME.lock().await;
    let Ok(address) = std::env::var("PHOTONFARM_TEST_POSTGRES") else {
        println!("PHOTONFARM_TEST_POSTGRES is not set: nobody is deposed");
        return;
    };
    let folder = tempfile::tempdir().expect("a folder");
    let location = |name: &str| StoreLocation {
        records: RecordsLocation::Postgres(address.clone()),
        ..StoreLocation::folder(folder.path().join(name))
    };
    let silent = open(&location("silent")).await;
    empty(&silent).await;
    silent.insert_scene(&scene("aa")).await.expect("it leads");
    let start = std::time::Instant::now();
    let next = loop {
        match Store::open(&location("next")).await {
            Ok(next) => break next,
            Err(problem) => assert!(matches!(problem, StoreError::InUse { .. }), "{problem}"),
        }
        assert!(start.elapsed() < std::time::Duration::from_secs(30), "a term ends when nobody prolongs it");
        tokio::time::sleep(std::time::Duration::from_millis(200)).await;
    };
    assert!(start.elapsed() > std::time::Duration::from_secs(5), "and not before");
    assert!(next.epoch() > silent.epoch());
    let user = User { name: "anna".parse().expect("a name"), role: Role::Admin, created: 0 };
    let id = JobId::after(next.last_job().await.expect("a mark"), 1_900_000_000_000);
    let refused = [
        silent.insert_scene(&scene("bb")).await,
        silent.delete_scene("aa").await,
        silent.insert_job(&job(id, "aa")).await,
        silent.update_job(&job(id, "aa")).await,
        silent.delete_job(id).await,
        silent.put_user(&user).await,
        silent.renew().await,
    ];
    assert!(refused.iter().all(|result| matches!(result, Err(StoreError::Deposed))), "{refused:?}");
    silent.close().await;
    next.renew().await.expect("it leads on");
    assert_eq!(next.scene_rows().await.expect("rows"), [scene("aa")]);
    // Whoever has the lock of its folder knows that it is dead, and need not wait.
    drop(next);
    let again = Store::open(&location("next")).await.expect("the same folder");
    again.close().await;
    // Whoever leaves in order leaves the term to others.
    Store::open(&location("other")).await.expect("nobody leads").close().await;
}

/// A database goes on with what it was asked while whoever asked is gone: the next one may find half of the tables made, and meet the rest.
#[tokio::test(flavor = "multi_thread")]
async fn stores_open_after_an_opening_that_was_given_up() {
    let folder = tempfile::tempdir().expect("a folder");
    for attempt in 0..80 {
        let location = StoreLocation::folder(folder.path().join(attempt.to_string()));
        let patience = std::time::Duration::from_micros(250 * attempt);
        drop(tokio::time::timeout(patience, Store::open(&location)).await);
        drop(open(&location).await);
    }
}
