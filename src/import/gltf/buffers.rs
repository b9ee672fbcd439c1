//! Buffers and the views into them.

use std::sync::Arc;

use super::entry::{Document, Entry};
use super::uri::{self, Uri};
use crate::scene::bundle::Bundle;
use crate::scene::error::{Location, SceneError};

/// The most bytes of buffers, and of files that the import makes of them.
const MEMORY_LIMIT: u64 = 2 << 30;

/// What is left of the memory that an import may take.
pub(super) struct Budget(u64);

impl Budget {
    pub(super) fn new() -> Self {
        Self(MEMORY_LIMIT)
    }

    /// Takes `bytes` for what stands at `entry`.
    ///
    /// # Errors
    /// When less than that is left of 2 GiB.
    pub(super) fn take(&mut self, bytes: u64, entry: &Entry<'_>) -> Result<(), SceneError> {
        self.0 = self.0.checked_sub(bytes).ok_or_else(|| {
            entry
                .error("from here on the scene takes more than 2 GiB", "split the scene, or share meshes between nodes")
        })?;
        Ok(())
    }
}

/// The content of all buffers of a file.
pub(super) struct Buffers {
    contents: Vec<Arc<[u8]>>,
}

impl Buffers {
    /// Reads every buffer. `binary` is the binary chunk of a GLB; files that are read are added to `files`.
    ///
    /// # Errors
    /// On files that are missing, content that is shorter than `byteLength`, and more than 2 GiB in all.
    pub(super) fn load(
        document: &Document,
        bundle: &Bundle,
        binary: Option<&[u8]>,
        budget: &mut Budget,
        files: &mut Vec<(String, Location)>,
    ) -> Result<Self, SceneError> {
        let mut contents = Vec::new();
        for (index, buffer) in document.root().objects("buffers")?.iter().enumerate() {
            let length = buffer.required_integer("byteLength")?;
            budget.take(length as u64, buffer)?;
            let content: Arc<[u8]> = match uri::read(buffer)? {
                Some(Uri::File(name)) => {
                    let content = bundle.read(&name, &buffer.location())?;
                    files.push((name, buffer.location()));
                    content
                }
                Some(Uri::Data(text)) => {
                    budget.take(uri::decoded_size(text), buffer)?;
                    uri::decode(text, buffer)?.into()
                }
                None => match binary {
                    Some(chunk) if index == 0 => chunk.into(),
                    _ => return Err(buffer.error("the buffer has no content", "export the scene without compression")),
                },
            };
            if content.len() < length {
                let problem = format!("the buffer has {} bytes where {length} belong", content.len());
                return Err(buffer.error(problem, "copy or export its file again"));
            }
            contents.push(content);
        }
        Ok(Self { contents })
    }

    /// The bytes of a view into a buffer.
    ///
    /// # Errors
    /// When it does not lie inside of its buffer.
    pub(super) fn view(&self, view: &Entry<'_>) -> Result<&[u8], SceneError> {
        let Some((index, buffer)) = view.reference("buffer", "buffers")? else {
            return Err(view.error("the view has no \"buffer\"", "export the scene again"));
        };
        let (offset, length) = (view.integer("byteOffset")?.unwrap_or(0), view.required_integer("byteLength")?);
        let end = buffer.required_integer("byteLength")?;
        let content = self.contents.get(index).and_then(|content| content.get(..end));
        let bytes = content.and_then(|content| content.get(offset..)).and_then(|rest| rest.get(..length));
        bytes.ok_or_else(|| {
            let problem = format!("{length} bytes from byte {offset} lead out of buffers[{index}], which has {end}");
            view.error(problem, "export the scene again")
        })
    }
}
