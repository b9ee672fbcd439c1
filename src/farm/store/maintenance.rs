//! Looking after a store: check, export, clean up. Best done while no coordinator uses it.

use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;

use serde_json::json;
use zip::ZipWriter;
use zip::write::SimpleFileOptions;

use super::blobs::{BlobEntry, BlobName};
use super::{Store, StoreError};

/// What a check found.
#[derive(Clone, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct CheckReport {
    /// Scenes with their bytes in order.
    pub scenes: usize,
    /// Jobs with all blobs that they name.
    pub jobs: usize,
    /// Bytes of all blobs.
    pub bytes: u64,
    /// Blobs that no record names.
    pub orphans: usize,
    /// Blobs that a record names and that are missing or damaged, one sentence each.
    pub problems: Vec<String>,
}

/// What a clean-up did.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize)]
pub struct CleanUpReport {
    /// Blobs deleted.
    pub blobs: usize,
    /// Their bytes.
    pub bytes: u64,
}

impl Store {
    /// Reads every blob that a record names.
    pub async fn check(&self) -> Result<CheckReport, StoreError> {
        let mut report = CheckReport::default();
        let entries = self.blobs.list().await?;
        report.bytes = entries.iter().map(|entry| entry.bytes).sum();
        let named = self.named_blobs().await?;
        report.orphans = entries.iter().filter(|entry| !named.contains(&entry.name)).count();
        for name in &named {
            if let Err(problem) = self.blobs.get(name).await {
                report.problems.push(problem.to_string());
            }
        }
        report.scenes = self.scene_rows().await?.len();
        report.jobs = self.job_rows().await?.len();
        Ok(report)
    }

    /// Deletes blobs that no record names. Nobody else is about to name one: a store has one user at a time.
    pub async fn clean_up(&self) -> Result<CleanUpReport, StoreError> {
        let named = self.named_blobs().await?;
        let mut report = CleanUpReport::default();
        for BlobEntry { name, bytes, .. } in self.blobs.list().await? {
            if !named.contains(&name) {
                self.blobs.delete(&name).await?;
                report.blobs += 1;
                report.bytes += bytes;
            }
        }
        Ok(report)
    }

    /// Writes all records, as lines of JSON, and all blobs that they name into a zip archive: all of it, or nothing.
    pub async fn export(&self, file: &Path) -> Result<(), StoreError> {
        let mut partial = file.as_os_str().to_owned();
        partial.push(".partial");
        let partial = Path::new(&partial);
        let written = self.write_archive(partial).await;
        let named = |problem: std::io::Error| StoreError::File {
            file: file.display().to_string(),
            problem: problem.to_string(),
        };
        match written {
            Ok(()) => std::fs::rename(partial, file).map_err(named),
            Err(problem) => {
                // It may not even have been made.
                let _ = std::fs::remove_file(partial);
                Err(problem)
            }
        }
    }

    async fn write_archive(&self, file: &Path) -> Result<(), StoreError> {
        let failed = |problem: &dyn std::fmt::Display| StoreError::File {
            file: file.display().to_string(),
            problem: problem.to_string(),
        };
        let output = std::fs::File::create(file).map_err(|problem| failed(&problem))?;
        let mut archive = ZipWriter::new(output);
        let options = SimpleFileOptions::default().large_file(true);
        let mut add = |name: &str, bytes: &[u8]| -> Result<(), StoreError> {
            archive.start_file(name, options).map_err(|problem| failed(&problem))?;
            archive.write_all(bytes).map_err(|problem| failed(&problem))
        };
        add("jobs.jsonl", self.job_lines().await?.as_bytes())?;
        add("sequences.jsonl", self.sequence_lines().await?.as_bytes())?;
        add("scenes.jsonl", self.scene_lines().await?.as_bytes())?;
        for name in self.named_blobs().await? {
            add(&format!("blobs/{name}"), &self.blobs.get(&name).await?)?;
        }
        archive.finish().map_err(|problem| failed(&problem))?;
        Ok(())
    }

    async fn named_blobs(&self) -> Result<BTreeSet<BlobName>, StoreError> {
        let scenes = self.scene_rows().await?.into_iter().map(|scene| BlobName::of_scene(&scene.hash));
        let jobs = self.job_rows().await?;
        let snapshots = jobs.iter().flat_map(|job| job.snapshots.all().cloned());
        Ok(scenes.chain(snapshots).collect())
    }

    async fn job_lines(&self) -> Result<String, StoreError> {
        let line = |job: super::jobs::JobRow| {
            let snapshots: Vec<String> = job.snapshots.all().map(ToString::to_string).collect();
            let record: serde_json::Value = serde_json::from_str(&job.record).unwrap_or_default();
            let line = json!({ "id": job.id, "state": job.state, "scene": job.scene, "created": job.created,
                "ended": job.ended, "record": record, "snapshots": snapshots });
            format!("{line}\n")
        };
        Ok(self.job_rows().await?.into_iter().map(line).collect())
    }

    async fn sequence_lines(&self) -> Result<String, StoreError> {
        let line = |sequence: super::sequences::SequenceRow| {
            let record: serde_json::Value = serde_json::from_str(&sequence.record).unwrap_or_default();
            let line = json!({ "id": sequence.id, "created": sequence.created, "record": record });
            format!("{line}\n")
        };
        Ok(self.sequence_rows().await?.into_iter().map(line).collect())
    }

    async fn scene_lines(&self) -> Result<String, StoreError> {
        let line = |scene: super::scenes::SceneRow| {
            let record: serde_json::Value = serde_json::from_str(&scene.record).unwrap_or_default();
            let line = json!({ "hash": scene.hash, "bytes": scene.bytes, "created": scene.created, "record": record });
            format!("{line}\n")
        };
        Ok(self.scene_rows().await?.into_iter().map(line).collect())
    }
}
