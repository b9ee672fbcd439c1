//! glTF files that a test writes down: JSON with its buffer inside, or as GLB.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::{Map, Value, json};

/// A glTF file whose single buffer grows with every accessor.
pub(crate) struct GltfFile {
    json: Map<String, Value>,
    pub(crate) buffer: Vec<u8>,
}

/// The numbers of an accessor.
pub(crate) enum Numbers<'a> {
    F32(&'a [f32]),
    U8(&'a [u8]),
    I8(&'a [i8]),
    U16(&'a [u16]),
    U32(&'a [u32]),
}

impl GltfFile {
    /// A file with the given lists and an asset.
    pub(crate) fn new(content: Value) -> Self {
        let Value::Object(mut json) = content else { panic!("not an object") };
        json.insert("asset".to_owned(), json!({"version": "2.0"}));
        Self { json, buffer: Vec::new() }
    }

    fn push(&mut self, list: &str, item: Value) -> usize {
        let list = self.json.entry(list).or_insert_with(|| json!([])).as_array_mut().expect("a list");
        list.push(item);
        list.len() - 1
    }

    /// Adds a view of `bytes`, and gives its index.
    pub(crate) fn view(&mut self, bytes: &[u8]) -> usize {
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        let offset = self.buffer.len();
        self.buffer.extend(bytes);
        self.push("bufferViews", json!({"buffer": 0, "byteOffset": offset, "byteLength": bytes.len()}))
    }

    /// Adds an accessor of `kind`, and gives its index.
    pub(crate) fn accessor(&mut self, kind: &str, numbers: Numbers<'_>) -> usize {
        let (code, count, bytes): (u32, usize, Vec<u8>) = match numbers {
            Numbers::F32(all) => (5126, all.len(), all.iter().flat_map(|number| number.to_le_bytes()).collect()),
            Numbers::U8(all) => (5121, all.len(), all.to_vec()),
            Numbers::I8(all) => (5120, all.len(), all.iter().flat_map(|number| number.to_le_bytes()).collect()),
            Numbers::U16(all) => (5123, all.len(), all.iter().flat_map(|number| number.to_le_bytes()).collect()),
            Numbers::U32(all) => (5125, all.len(), all.iter().flat_map(|number| number.to_le_bytes()).collect()),
        };
        let width = match kind {
            "SCALAR" => 1,
            "VEC2" => 2,
            "VEC3" => 3,
            _ => 4,
        };
        let view = self.view(&bytes);
        self.push("accessors", json!({"bufferView": view, "componentType": code, "count": count / width, "type": kind}))
    }

    /// Changes accessor `index`.
    pub(crate) fn change_accessor(&mut self, index: usize, key: &str, value: Value) {
        self.json["accessors"][index][key] = value;
    }

    /// Adds the triangle (0,0,0), (1,0,0), (0,1,0) as accessor, mesh and the items that are given.
    pub(crate) fn with_triangle(content: Value) -> Self {
        let mut file = Self::new(content);
        let positions = file.accessor("VEC3", Numbers::F32(&[0.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0, 1.0, 0.0]));
        file.json.entry("meshes").or_insert_with(|| json!([{"primitives": [{"attributes": {"POSITION": positions}}]}]));
        file
    }

    /// The file with its buffer in a `uri`.
    pub(crate) fn gltf(&self, uri: &str) -> String {
        let mut json = self.json.clone();
        json.insert("buffers".to_owned(), json!([{"byteLength": self.buffer.len(), "uri": uri}]));
        Value::Object(json).to_string()
    }

    /// The file with its buffer inside of the JSON.
    pub(crate) fn text(&self) -> String {
        self.gltf(&format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.buffer)))
    }

    /// The file as GLB.
    pub(crate) fn glb(&self) -> Vec<u8> {
        let mut json = self.json.clone();
        json.insert("buffers".to_owned(), json!([{"byteLength": self.buffer.len()}]));
        let mut text = Value::Object(json).to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let mut buffer = self.buffer.clone();
        buffer.resize(buffer.len().next_multiple_of(4), 0);
        let mut bytes = b"glTF".to_vec();
        let word = |number: usize| (number as u32).to_le_bytes();
        bytes.extend(word(2));
        bytes.extend(word(28 + text.len() + buffer.len()));
        bytes.extend(word(text.len()));
        bytes.extend(b"JSON");
        bytes.extend(text);
        bytes.extend(word(buffer.len()));
        bytes.extend(b"BIN\0");
        bytes.extend(buffer);
        bytes
    }
}
