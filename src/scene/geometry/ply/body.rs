//! The numbers of a PLY file, whatever their encoding.

use super::super::super::error::{Location, SceneError};
use super::header::{Element, Encoding, Header, Kind, Property};

/// Reads numbers one after the other.
pub(super) struct Body<'a> {
    bytes: &'a [u8],
    position: usize,
    encoding: Encoding,
    /// The current line of an ASCII file.
    line: u32,
    location: &'a Location,
}

impl<'a> Body<'a> {
    pub(super) fn new(bytes: &'a [u8], header: &Header, location: &'a Location) -> Self {
        Self { bytes, position: header.body, encoding: header.encoding, line: header.lines + 1, location }
    }

    /// An error at the current place.
    pub(super) fn error(&self, problem: &str, remedy: &str) -> SceneError {
        match self.encoding {
            Encoding::Ascii => SceneError::new(&Location { line: self.line, ..self.location.clone() }, problem, remedy),
            _ => SceneError::new(self.location, format!("{problem} (at byte {})", self.position), remedy),
        }
    }

    fn remaining(&self) -> usize {
        self.bytes.len() - self.position
    }

    /// The element's count, which the rest of the file is long enough for. Nothing is read for an element without
    /// properties.
    pub(super) fn checked_count(&self, element: &Element) -> Result<usize, SceneError> {
        // In ASCII a number is at least one digit and a separator, and the last separator may be missing.
        let least = |property: &Property| match (self.encoding, property) {
            (Encoding::Ascii, _) => 2,
            (_, Property::Scalar { kind, .. }) => kind.size(),
            (_, Property::List { count, .. }) => count.size(),
        };
        let item_size: usize = element.properties.iter().map(least).sum();
        if item_size == 0 {
            return Ok(0);
        }
        let available = (self.remaining() + 1) / item_size;
        match usize::try_from(element.count) {
            Ok(count) if count <= available && u32::try_from(count).is_ok() => Ok(count),
            _ => {
                let problem = format!(
                    "the header promises {} of element \"{}\", but the rest of the file has room for {available}",
                    element.count,
                    element.name.chars().take(60).collect::<String>(),
                );
                Err(self.error(&problem, "the file is cut short or damaged: copy it again"))
            }
        }
    }

    fn skip_spaces(&mut self) {
        while let Some(byte) = self.bytes.get(self.position).filter(|byte| byte.is_ascii_whitespace()) {
            self.line += u32::from(*byte == b'\n');
            self.position += 1;
        }
    }

    /// The next number. Every type's values fit into an f64.
    pub(super) fn scalar(&mut self, kind: Kind) -> Result<f64, SceneError> {
        match self.encoding {
            Encoding::Ascii => self.word(),
            Encoding::LittleEndian => Ok(match kind {
                Kind::I8 => f64::from(i8::from_le_bytes(self.take()?)),
                Kind::U8 => f64::from(u8::from_le_bytes(self.take()?)),
                Kind::I16 => f64::from(i16::from_le_bytes(self.take()?)),
                Kind::U16 => f64::from(u16::from_le_bytes(self.take()?)),
                Kind::I32 => f64::from(i32::from_le_bytes(self.take()?)),
                Kind::U32 => f64::from(u32::from_le_bytes(self.take()?)),
                Kind::F32 => f64::from(f32::from_le_bytes(self.take()?)),
                Kind::F64 => f64::from_le_bytes(self.take()?),
            }),
            Encoding::BigEndian => Ok(match kind {
                Kind::I8 => f64::from(i8::from_be_bytes(self.take()?)),
                Kind::U8 => f64::from(u8::from_be_bytes(self.take()?)),
                Kind::I16 => f64::from(i16::from_be_bytes(self.take()?)),
                Kind::U16 => f64::from(u16::from_be_bytes(self.take()?)),
                Kind::I32 => f64::from(i32::from_be_bytes(self.take()?)),
                Kind::U32 => f64::from(u32::from_be_bytes(self.take()?)),
                Kind::F32 => f64::from(f32::from_be_bytes(self.take()?)),
                Kind::F64 => f64::from_be_bytes(self.take()?),
            }),
        }
    }

    fn take<const N: usize>(&mut self) -> Result<[u8; N], SceneError> {
        let Some(bytes) = self.bytes[self.position..].first_chunk::<N>() else { return Err(self.ended()) };
        self.position += N;
        Ok(*bytes)
    }

    fn word(&mut self) -> Result<f64, SceneError> {
        self.skip_spaces();
        let rest = &self.bytes[self.position..];
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        if length == 0 {
            return Err(self.ended());
        }
        let word = &rest[..length];
        let number = std::str::from_utf8(word).ok().and_then(|text| text.parse().ok());
        let number = number.ok_or_else(|| {
            let shown = String::from_utf8_lossy(&word[..length.min(40)]);
            self.error(&format!("\"{shown}\" is not a number"), "export the mesh again")
        })?;
        self.position += length;
        Ok(number)
    }

    fn ended(&self) -> SceneError {
        self.error("the file ends too early", "the file is cut short or damaged: copy it again")
    }

    fn list_length(&mut self, count: Kind, item: Kind) -> Result<usize, SceneError> {
        let length = self.scalar(count)?;
        let least = if self.encoding == Encoding::Ascii { 2 } else { item.size() };
        let available = (self.remaining() + 1) / least;
        if !(0.0..=available as f64).contains(&length) || length.fract() != 0.0 {
            let problem = format!("a list of {length} numbers, where the rest of the file has room for {available}");
            return Err(self.error(&problem, "the file is cut short or damaged: copy it again"));
        }
        Ok(length as usize)
    }

    /// Passes over a list.
    pub(super) fn skip_list(&mut self, count: Kind, item: Kind) -> Result<(), SceneError> {
        for _ in 0..self.list_length(count, item)? {
            self.scalar(item)?;
        }
        Ok(())
    }

    /// Reads a list of vertex indices.
    pub(super) fn indices(&mut self, count: Kind, item: Kind, indices: &mut Vec<u32>) -> Result<(), SceneError> {
        indices.clear();
        for _ in 0..self.list_length(count, item)? {
            let index = self.scalar(item)?;
            if !(0.0..=f64::from(u32::MAX)).contains(&index) || index.fract() != 0.0 {
                return Err(self.error(&format!("{index} is not the index of a vertex"), "repair the mesh"));
            }
            indices.push(index as u32);
        }
        Ok(())
    }
}
