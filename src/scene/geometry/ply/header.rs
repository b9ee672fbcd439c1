//! The header of a PLY file.

use super::super::super::bundle::without_byte_order_mark;
use super::super::super::error::{Location, SceneError};

/// How the numbers of the body are written.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    LittleEndian,
    BigEndian,
}

/// The type of a number.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Kind {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    F32,
    F64,
}

impl Kind {
    fn named(name: &str) -> Option<Self> {
        Some(match name {
            "char" | "int8" => Self::I8,
            "uchar" | "uint8" => Self::U8,
            "short" | "int16" => Self::I16,
            "ushort" | "uint16" => Self::U16,
            "int" | "int32" => Self::I32,
            "uint" | "uint32" => Self::U32,
            "float" | "float32" => Self::F32,
            "double" | "float64" => Self::F64,
            _ => return None,
        })
    }

    /// Bytes of one number in a binary body.
    pub(super) fn size(self) -> usize {
        match self {
            Self::I8 | Self::U8 => 1,
            Self::I16 | Self::U16 => 2,
            Self::I32 | Self::U32 | Self::F32 => 4,
            Self::F64 => 8,
        }
    }
}

/// A column of an element.
pub(super) enum Property {
    Scalar { kind: Kind, name: String },
    List { count: Kind, item: Kind, name: String },
}

impl Property {
    pub(super) fn name(&self) -> &str {
        match self {
            Self::Scalar { name, .. } | Self::List { name, .. } => name,
        }
    }
}

/// A table of the body.
pub(super) struct Element {
    pub name: String,
    pub count: u64,
    pub properties: Vec<Property>,
}

/// What the body holds, and where it begins.
pub(super) struct Header {
    pub encoding: Encoding,
    pub elements: Vec<Element>,
    /// First byte of the body.
    pub body: usize,
    /// Lines of the header.
    pub lines: u32,
}

/// Reads the lines up to `end_header`.
pub(super) fn read(bytes: &[u8], location: &Location) -> Result<Header, SceneError> {
    const REMEDY: &str = "export the mesh again";
    let body = bytes.len() - without_byte_order_mark(bytes).len();
    let mut header = Header { encoding: Encoding::Ascii, elements: Vec::new(), body, lines: 0 };
    let mut encoding = None;
    loop {
        let rest = &bytes[header.body..];
        let place = Location { line: header.lines + 1, ..location.clone() };
        let (Some(end), true) = (rest.iter().position(|byte| *byte == b'\n'), header.lines < 10_000) else {
            let problem = if header.lines == 0 { "this is not a PLY file" } else { "the PLY header does not end" };
            return Err(SceneError::new(&place, problem, REMEDY));
        };
        header.body += end + 1;
        header.lines += 1;
        let line = String::from_utf8_lossy(&rest[..end]);
        let words: Vec<&str> = line.split_whitespace().collect();
        let refuse = || {
            let shown: String = line.trim().chars().take(60).collect();
            SceneError::new(&place, format!("{shown:?} is not a line of a PLY header"), REMEDY)
        };
        match words.as_slice() {
            ["ply"] if header.lines == 1 => {}
            _ if header.lines == 1 => return Err(SceneError::new(&place, "this is not a PLY file", REMEDY)),
            ["comment" | "obj_info", ..] | [] => {}
            ["format", format, _version] => encoding = Some(encoding_named(format).ok_or_else(refuse)?),
            ["element", name, count] => {
                let count = count.parse().map_err(|_| refuse())?;
                if header.elements.iter().any(|element| element.name == *name) {
                    return Err(refuse());
                }
                header.elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
            }
            ["property", rest @ ..] => {
                let property = property(rest).ok_or_else(refuse)?;
                header.elements.last_mut().ok_or_else(refuse)?.properties.push(property);
            }
            ["end_header"] => break,
            _ => return Err(refuse()),
        }
    }
    header.encoding = encoding.ok_or_else(|| SceneError::new(location, "the PLY header has no format", REMEDY))?;
    Ok(header)
}

fn encoding_named(name: &str) -> Option<Encoding> {
    match name {
        "ascii" => Some(Encoding::Ascii),
        "binary_little_endian" => Some(Encoding::LittleEndian),
        "binary_big_endian" => Some(Encoding::BigEndian),
        _ => None,
    }
}

fn property(words: &[&str]) -> Option<Property> {
    match words {
        ["list", count, item, name] => {
            let count = Kind::named(count).filter(|kind| !matches!(kind, Kind::F32 | Kind::F64))?;
            Some(Property::List { count, item: Kind::named(item)?, name: (*name).to_owned() })
        }
        [kind, name] => Some(Property::Scalar { kind: Kind::named(kind)?, name: (*name).to_owned() }),
        _ => None,
    }
}
