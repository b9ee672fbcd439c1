//! Mitsuba's serialized meshes: every version and precision gives the mesh that was written, and damaged files are
//! errors, never panics, and never take much memory.

use std::fmt::Write as _;
use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use photonfarm::scene::SceneError;
use photonfarm::scene::error::Location;
use photonfarm::scene::geometry::serialized;
use photonfarm::scene::geometry::triangle_mesh::{MeshValues, TriangleMesh};

const NORMALS: u32 = 0x0001;
const COORDINATES: u32 = 0x0002;
const COLORS: u32 = 0x0008;
const FACE_NORMALS: u32 = 0x0010;
const SINGLE: u32 = 0x1000;
const DOUBLE: u32 = 0x2000;

fn place() -> Location {
    Location { file: "test.serialized".to_owned(), ..Location::default() }
}

fn read(bytes: &[u8], index: usize) -> Result<TriangleMesh, SceneError> {
    serialized::read(bytes, index, &place())
}

fn square(x: f32) -> TriangleMesh {
    TriangleMesh {
        positions: vec![[x, 0.0, 0.0], [x + 1.0, 0.0, 0.0], [x + 1.0, 1.0, 0.0], [x, 1.0, 0.25]],
        normals: vec![[0.0, 0.0, 1.0], [0.0, 0.5, 0.5], [0.25, 0.0, 1.0], [0.0, 0.0, 1.0]],
        texture_coordinates: vec![[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.5]],
        triangles: vec![[0, 1, 2], [0, 2, 3]],
        ..TriangleMesh::default()
    }
}

/// What is compressed: flags, name, counts and numbers.
fn content(mesh: &TriangleMesh, version: u16, flags: u32) -> Vec<u8> {
    let mut bytes = flags.to_le_bytes().to_vec();
    if version == 4 {
        bytes.extend(b"square\0");
    }
    bytes.extend((mesh.positions.len() as u64).to_le_bytes());
    bytes.extend((mesh.triangles.len() as u64).to_le_bytes());
    let mut push = |number: f32| match flags & DOUBLE {
        0 => bytes.extend(number.to_le_bytes()),
        _ => bytes.extend(f64::from(number).to_le_bytes()),
    };
    mesh.positions.iter().flatten().for_each(|number| push(*number));
    if flags & NORMALS != 0 {
        mesh.normals.iter().flatten().for_each(|number| push(*number));
    }
    if flags & COORDINATES != 0 {
        mesh.texture_coordinates.iter().flatten().for_each(|number| push(*number));
    }
    if flags & COLORS != 0 {
        (0..mesh.positions.len() * 3).for_each(|number| push(number as f32));
    }
    mesh.triangles.iter().flatten().for_each(|index| bytes.extend(index.to_le_bytes()));
    bytes
}

fn compressed(content: &[u8], version: u16) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
    encoder.write_all(content).unwrap();
    let mut bytes = [0x041C_u16.to_le_bytes(), version.to_le_bytes()].concat();
    bytes.extend(encoder.finish().unwrap());
    bytes
}

/// A file of several meshes with the list of their places.
fn file(meshes: &[Vec<u8>], version: u16) -> Vec<u8> {
    let (mut bytes, mut offsets) = (Vec::new(), Vec::new());
    for mesh in meshes {
        offsets.push(bytes.len());
        bytes.extend(mesh);
    }
    for offset in offsets {
        let number = (offset as u64).to_le_bytes();
        bytes.extend(if version == 4 { &number[..] } else { &number[..4] });
    }
    bytes.extend((meshes.len() as u32).to_le_bytes());
    bytes
}

#[test]
fn every_version_and_precision_gives_the_mesh() {
    for version in [3, 4] {
        for precision in [SINGLE, DOUBLE] {
            for optional in 0..8 {
                let [normals, coordinates, colors] = [1, 2, 4].map(|bit| optional & bit != 0);
                let flag = |flag: u32, there: bool| if there { flag } else { 0 };
                let flags = precision | flag(NORMALS, normals) | flag(COORDINATES, coordinates) | flag(COLORS, colors);
                let meshes = [0.0, 5.0, -3.0].map(square);
                let parts: Vec<Vec<u8>> =
                    meshes.iter().map(|mesh| compressed(&content(mesh, version, flags), version)).collect();
                let bytes = file(&parts, version);
                for (index, mut expected) in meshes.into_iter().enumerate() {
                    if !normals {
                        expected.normals.clear();
                    }
                    if !coordinates {
                        expected.texture_coordinates.clear();
                    }
                    if colors {
                        let (name, numbers) = ("vertex_color".to_owned(), (0..12_u8).map(f32::from).collect());
                        expected.attributes.push(MeshValues { name, channels: 3, numbers });
                    }
                    assert_eq!(read(&bytes, index).unwrap(), expected, "version {version}, flags {flags:x}");
                }
            }
        }
    }
}

#[test]
fn flat_shading_is_kept() {
    let mesh = read(&compressed(&content(&square(0.0), 4, SINGLE | FACE_NORMALS), 4), 0).unwrap();
    assert!(mesh.face_normals);
}

/// A file without the list at its end is read when its first mesh is asked for.
#[test]
fn a_first_mesh_needs_no_list() {
    assert_eq!(
        read(&compressed(&content(&square(0.0), 4, SINGLE | NORMALS | COORDINATES), 4), 0).unwrap(),
        square(0.0)
    );
}

fn with_counts(vertices: u64, triangles: u64) -> Vec<u8> {
    let mut content = SINGLE.to_le_bytes().to_vec();
    content.extend(b"\0");
    content.extend(vertices.to_le_bytes());
    content.extend(triangles.to_le_bytes());
    content.extend([0; 4096]);
    compressed(&content, 4)
}

#[test]
fn serialized_meshes_that_cannot_be() {
    let good = content(&square(0.0), 4, SINGLE);
    let changed = |change: &dyn Fn(&mut TriangleMesh)| {
        let mut mesh = square(0.0);
        change(&mut mesh);
        compressed(&content(&mesh, 4, SINGLE | NORMALS | COORDINATES), 4)
    };
    let whole = compressed(&good, 4);
    let mut damaged = whole.clone();
    damaged[10] ^= 0x55;
    damaged[20] ^= 0x55;
    let two = file(&[whole.clone(), whole.clone()], 4);
    let mut lost = two.clone();
    let list = lost.len() - 20;
    lost[list + 8] ^= 0xff;
    let mut many = two.clone();
    let end = many.len() - 4;
    many[end..].copy_from_slice(&[0xff; 4]);
    let mut nameless = SINGLE.to_le_bytes().to_vec();
    nameless.extend([b'a'; 10_000]);
    let cases: Vec<(&str, Vec<u8>, usize)> = vec![
        ("empty file", Vec::new(), 0),
        ("another kind of file", b"ply\nformat ascii 1.0\n".to_vec(), 0),
        ("version 5", [0x1c, 4, 5, 0, 1, 2, 3].to_vec(), 0),
        ("cut short", whole[..whole.len() / 2].to_vec(), 0),
        ("cut short before the first number", whole[..4].to_vec(), 0),
        ("content cut short", compressed(&good[..good.len() - 5], 4), 0),
        ("damaged", damaged, 0),
        ("index beyond the meshes", two.clone(), 2),
        ("damaged place", lost, 1),
        ("damaged number of meshes", many, 1),
        ("no list", vec![0x1c, 4, 4, 0], 1),
        ("name without end", compressed(&nameless, 4), 0),
        ("no triangles", with_counts(4, 0), 0),
        ("far too many vertices", with_counts(1 << 60, 1), 0),
        ("far too many triangles", with_counts(3, u64::MAX), 0),
        ("more vertices than are there", with_counts(1000, 1), 0),
        ("index of no vertex", changed(&|mesh| mesh.triangles[1][2] = 4), 0),
        ("position that is not a number", changed(&|mesh| mesh.positions[2][1] = f32::NAN), 0),
        ("infinite texture coordinate", changed(&|mesh| mesh.texture_coordinates[3][0] = f32::INFINITY), 0),
    ];
    let mut report = String::new();
    for (what, bytes, index) in cases {
        match read(&bytes, index) {
            Ok(_) => panic!("{what} is no error"),
            Err(error) => writeln!(report, "{what}\n    {error}").unwrap(),
        }
    }
    insta::assert_snapshot!(report);
}

/// Numbers that are the same in every run (SplitMix64).
struct Numbers(u64);

impl Numbers {
    fn below(&mut self, end: usize) -> usize {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let z = (self.0 ^ self.0 >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
        ((z ^ z >> 31) % end as u64) as usize
    }
}

/// Damage before and after compression, in the whole file and in its list.
#[test]
fn damaged_files_are_errors_and_never_panics() {
    let mut numbers = Numbers(1);
    let mut refused = 0;
    for round in 0..4000 {
        let mut content = content(&square(0.0), 4, SINGLE | NORMALS | COORDINATES);
        if round % 2 == 0 {
            let at = numbers.below(content.len());
            content[at] = numbers.below(256) as u8;
        }
        let mesh = compressed(&content, 4);
        let mut bytes = file(&[mesh.clone(), mesh], 4);
        if round % 4 != 0 {
            let at = numbers.below(bytes.len());
            bytes[at] = numbers.below(256) as u8;
        }
        if round % 8 == 7 {
            bytes.truncate(numbers.below(bytes.len()));
        }
        for index in 0..3 {
            refused += usize::from(read(&bytes, index).is_err());
        }
    }
    assert!((4000..12_000).contains(&refused), "{refused} of 12000 reads are refused");
}
