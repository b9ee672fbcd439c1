//! Cryptomatte through the API: a picture's objects and materials are selected by name, as compositors do it.

use std::collections::BTreeMap;
use std::io::Cursor;

use exr::meta::MetaData;
use exr::meta::attribute::AttributeValue;
use exr::prelude::SampleType;
use serde_json::{Value, json};

use crate::end_to_end::Farm;
use crate::exr_channels::exr_channels;

/// Pixels along either side.
const SIDE: usize = 40;
const NEAR: &str = "Kugel \"nah\" \\ 1";
const FAR: &str = "шар ●";
/// Center and radius of the two spheres.
const SPHERES: [([f64; 3], f64); 2] = [([-0.5, 0.2, 0.0], 1.0), ([0.8, -0.3, -1.0], 0.9)];
/// Half the side of the wall behind them.
const WALL: f64 = 2.2;

/// Two spheres of different materials, one a little before the other, and a wall without names at z = -3 that the corners look past.
fn scene() -> String {
    let sphere = |index: usize, id: &str, material: &str| {
        let ([x, y, z], radius) = SPHERES[index];
        format!(
            "<shape type='sphere' id='{id}'><point name='center' x='{x}' y='{y}' z='{z}'/><float name='radius' value='{radius}'/>{material}</shape>"
        )
    };
    let film = format!(
        "<film type='hdrfilm'><integer name='width' value='{SIDE}'/><integer name='height' value='{SIDE}'/><rfilter type='box'/></film>"
    );
    let near = sphere(0, "Kugel &quot;nah&quot; \\ 1", "<ref id='red'/>");
    let far = sphere(1, FAR, "<bsdf type='twosided'><bsdf type='diffuse' id='blue'/></bsdf>");
    format!(
        "<scene version='3.0.0'><sensor type='perspective'><float name='fov' value='40'/>
        <transform name='to_world'><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/></transform>{film}</sensor>
        <emitter type='constant'/><bsdf type='conductor' id='red'/>{near}{far}
        <shape type='rectangle'><transform name='to_world'><scale value='{WALL}'/><translate z='-3'/></transform></shape></scene>"
    )
}

/// What a camera ray through a place of the film meets: a sphere, or the wall as 2.
fn met(x: f64, y: f64) -> Option<usize> {
    let half_extent = 20_f64.to_radians().tan();
    let direction = [(2.0 * x - 1.0) * half_extent, (1.0 - 2.0 * y) * half_extent, -1.0];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let distance = |([x, y, z], radius): ([f64; 3], f64)| {
        let center = [x, y, z - 5.0];
        let (a, b, c) = (dot(direction, direction), dot(direction, center), dot(center, center) - radius * radius);
        let discriminant = b * b - a * c;
        (discriminant > 0.0).then(|| (b - discriminant.sqrt()) / a)
    };
    let hits = SPHERES.map(distance);
    let nearest =
        (0..2).filter(|index| hits[*index].is_some()).min_by(|a, b| hits[*a].partial_cmp(&hits[*b]).expect("numbers"));
    let is_on_wall = direction[0].abs() * 8.0 < WALL && direction[1].abs() * 8.0 < WALL;
    nearest.or(is_on_wall.then_some(2))
}

/// The share of a pixel that shows a thing, of 32 × 32 places.
fn silhouette(thing: usize) -> Vec<f32> {
    const PLACES: usize = 32;
    let share = |pixel: usize| {
        let place = |cell: usize, step: usize| (cell as f64 + (step as f64 + 0.5) / PLACES as f64) / SIDE as f64;
        let shown =
            |step: &usize| met(place(pixel % SIDE, step % PLACES), place(pixel / SIDE, step / PLACES)) == Some(thing);
        (0..PLACES * PLACES).filter(shown).count() as f32 / (PLACES * PLACES) as f32
    };
    (0..SIDE * SIDE).map(share).collect()
}

/// A file as a compositor reads it.
struct Decoded {
    channels: BTreeMap<String, Vec<f32>>,
    types: BTreeMap<String, SampleType>,
    attributes: BTreeMap<String, String>,
}

impl Decoded {
    fn of(bytes: &[u8]) -> Self {
        let file = MetaData::read_from_buffered(Cursor::new(bytes), false).expect("an EXR");
        let header = &file.headers[0];
        let text = |value: &AttributeValue| match value {
            AttributeValue::Text(text) => Some(String::from_utf8(text.as_slice().to_vec()).expect("UTF-8")),
            _ => None,
        };
        let attributes = header.own_attributes.other.iter();
        let types = header.channels.list.iter().map(|channel| (channel.name.to_string(), channel.sample_type));
        Self {
            channels: exr_channels(bytes),
            types: types.collect(),
            attributes: attributes.filter_map(|(name, value)| Some((name.to_string(), text(value)?))).collect(),
        }
    }

    /// The value of an attribute of a kind of matte.
    fn attribute(&self, kind: &str, what: &str) -> &str {
        let named = |(name, value): (&String, &String)| {
            name.ends_with("/name").then_some(name).filter(|_| value == kind).cloned()
        };
        let name = self.attributes.iter().find_map(named).expect("a matte of this kind");
        let key = name.strip_prefix("cryptomatte/").and_then(|rest| rest.strip_suffix("/name")).expect("a key");
        assert_eq!(key.len(), 7, "{key}");
        &self.attributes[&format!("cryptomatte/{key}/{what}")]
    }

    fn manifest(&self, kind: &str) -> BTreeMap<String, String> {
        serde_json::from_str(self.attribute(kind, "manifest")).expect("a manifest")
    }

    /// The pairs of id and coverage of a pixel.
    fn pairs(&self, kind: &str, pixel: usize) -> Vec<(f32, f32)> {
        let channel = |layer: usize, letter: &str| self.channels[&format!("{kind}{layer:02}.{letter}")][pixel];
        let pairs =
            |layer: usize| [("R", "G"), ("B", "A")].map(|(id, cover)| (channel(layer, id), channel(layer, cover)));
        (0..3).flat_map(pairs).collect()
    }

    /// How much of each pixel a name covers.
    fn matte(&self, kind: &str, name: &str) -> Vec<f32> {
        let id = u32::from_str_radix(&self.manifest(kind)[name], 16).expect("eight digits");
        let coverage = |pixel: usize| {
            self.pairs(kind, pixel)
                .iter()
                .filter(|(found, _)| found.to_bits() == id)
                .map(|(_, coverage)| coverage)
                .sum()
        };
        (0..SIDE * SIDE).map(coverage).collect()
    }
}

async fn decoded(query: &str) -> Decoded {
    let farm = Farm::start(1).await;
    let job = json!({ "scene_inline": scene(), "method": "sppm", "parameters": { "photons_per_pass": 500 }, "stop": { "passes": 1 } });
    let answer = farm.post("/v1/jobs", job.to_string()).await.text().await.expect("text");
    let answer: Value = serde_json::from_str(&answer).expect("JSON");
    let id = answer["id"].as_str().unwrap_or_else(|| panic!("{answer}"));
    farm.events(id).await;
    for path in ["pixels?layer=crypto_object", "map.png?layer=crypto_material", "map.png?layer=CryptoObject00.R"] {
        assert_eq!(farm.get(&format!("/v1/jobs/{id}/{path}")).await.status().as_u16(), 422, "{path}");
    }
    let bytes = farm.get(&format!("/v1/jobs/{id}/image.exr?{query}")).await.bytes().await.expect("bytes");
    Decoded::of(&bytes)
}

fn assert_silhouette(matte: &[f32], thing: usize) {
    let (mut edge, mut errors) = (0, 0.0);
    for (pixel, (found, expected)) in matte.iter().zip(silhouette(thing)).enumerate() {
        let is_edge = expected > 0.0 && expected < 1.0;
        // Sixteen places, one anywhere in each sixteenth, tell the share of a pixel that an edge crosses by a few of them at most.
        let allowed = if is_edge { 3.5 / 16.0 } else { 0.0 };
        assert!((found - expected).abs() <= allowed, "thing {thing}, pixel {pixel}: {found} instead of {expected}");
        edge += usize::from(is_edge);
        errors += (found - expected).abs();
    }
    let mean = errors / edge as f32;
    assert!(edge > 30 && mean < 1.0 / 16.0, "thing {thing}: {edge} pixels of the edge are wrong by {mean}");
    let covered = matte.iter().filter(|coverage| **coverage == 1.0).count();
    assert!(covered > 50, "thing {thing} covers only {covered} pixels");
}

#[tokio::test(flavor = "multi_thread")]
async fn mattes_select_by_name_what_the_camera_sees() {
    let file = decoded("layers=crypto_material,crypto_object&half=true").await;
    for kind in ["CryptoObject", "CryptoMaterial"] {
        assert_eq!(file.attribute(kind, "hash"), "MurmurHash3_32");
        assert_eq!(file.attribute(kind, "conversion"), "uint32_to_float32");
        let layers = (0..3).flat_map(|layer| ["R", "G", "B", "A"].map(|letter| format!("{kind}{layer:02}.{letter}")));
        layers.for_each(|name| assert_eq!(file.types[&name], SampleType::F32, "{name}"));
    }
    assert_eq!(file.types["R"], SampleType::F16, "colors have half the bits");
    let objects: Vec<String> = file.manifest("CryptoObject").into_keys().collect();
    assert_eq!(objects, [NEAR, "shape 3", FAR]);
    let materials: Vec<String> = file.manifest("CryptoMaterial").into_keys().collect();
    assert_eq!(materials, ["blue", "default material", "red"]);
    for (thing, (object, material)) in
        [(NEAR, "red"), (FAR, "blue"), ("shape 3", "default material")].into_iter().enumerate()
    {
        let matte = file.matte("CryptoObject", object);
        assert_silhouette(&matte, thing);
        assert_eq!(matte, file.matte("CryptoMaterial", material), "each has a material of its own");
    }
    assert_pairs_are_valid(&file);
}

/// Ids are those of the manifest, coverage falls with the rank, and is 1 in all where no ray meets nothing.
fn assert_pairs_are_valid(file: &Decoded) {
    let (seen, mut whole) = (silhouette(0).into_iter().zip(silhouette(1)).zip(silhouette(2)), 0);
    let known: Vec<u32> =
        file.manifest("CryptoObject").values().map(|id| u32::from_str_radix(id, 16).expect("eight digits")).collect();
    for (pixel, ((near, far), wall)) in seen.enumerate() {
        let pairs = file.pairs("CryptoObject", pixel);
        assert!(pairs.windows(2).all(|two| two[0].1 >= two[1].1), "pixel {pixel}: {pairs:?}");
        for (id, coverage) in &pairs {
            let is_known = known.contains(&id.to_bits()) && id.is_normal();
            assert!(if *coverage > 0.0 { is_known } else { id.to_bits() == 0 }, "pixel {pixel}: {pairs:?}");
        }
        let sum: f32 = pairs.iter().map(|(_, coverage)| coverage).sum();
        let expected = near + far + wall;
        if expected == 1.0 || expected == 0.0 {
            assert_eq!(sum, expected, "pixel {pixel}: {pairs:?}");
            whole += usize::from(sum == 1.0);
        }
    }
    assert!(whole > 500, "only {whole} pixels show nothing but things");
}

#[tokio::test(flavor = "multi_thread")]
async fn pictures_without_mattes_say_nothing_of_them() {
    let file = decoded("layers=depth").await;
    assert!(file.attributes.keys().all(|name| !name.starts_with("cryptomatte")), "{:?}", file.attributes.keys());
    assert!(file.channels.keys().all(|name| !name.starts_with("Crypto")));
}
