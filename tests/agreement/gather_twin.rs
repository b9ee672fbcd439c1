//! The photon map's fast loop against its plain twin and against a search through all photons; and that its order does
//! not depend on threads.

use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::math::{Rgb, Vec3, octahedral, warp};
use photonfarm::transport::photon_map::{
    CompactPhoton, GatherQuery, Gathered, Grid, KdTree, Nearest, Photon, PhotonChunk, PhotonLookup, PhotonMap,
    StoredPhoton,
};

const LOW: Vec3 = Vec3::new(-1.0, -2.0, 0.5);
const HIGH: Vec3 = Vec3::new(3.0, 1.0, 2.0);

fn uniform(family: u32, index: u32, block: u32) -> [f32; 4] {
    PathRandom::new(11, Stream::Photon, family, index).block(block)
}

fn point(u: [f32; 4]) -> Vec3 {
    LOW + Vec3::new(u[0], u[1], u[2]) * (HIGH - LOW)
}

/// Photons on flat surfaces (the box's faces and planes inside it) and some that hang in the air.
fn cloud(family: u32, count: u32) -> Vec<Photon> {
    let photon = |index: u32| {
        let (place, other) = (uniform(family, index, 0), uniform(family, index, 1));
        let mut position = point(place);
        let mut normal = warp::sphere([other[0], other[1]]);
        if !index.is_multiple_of(4) {
            let axis = (index % 3) as usize;
            let steps = (place[3] * 5.0).floor() / 4.0;
            position[axis] = LOW[axis] + steps * (HIGH - LOW)[axis];
            normal = Vec3::ZERO;
            normal[axis] = if place[3] < 0.5 { 1.0 } else { -1.0 };
        }
        let flux = Rgb::new(other[2], other[3], 1.0) * 3.0;
        Photon::new(position, octahedral::encode(normal), normal, flux, 1 + index % 40, index.is_multiple_of(5))
    };
    (0..count).map(photon).collect()
}

/// Queries on photons, in the air, at and outside the borders of the grid, with tiny and huge radii.
fn queries(photons: &[Photon], family: u32, count: u32) -> Vec<GatherQuery> {
    let query = |index: u32| {
        let (place, other) = (uniform(family, index, 2), uniform(family, index, 3));
        let mut position = match index % 5 {
            0 => point(place),
            _ => Vec3::from_array(photons[(place[3] * photons.len() as f32) as usize].position),
        };
        let axis = (index % 3) as usize;
        match index % 7 {
            0 => position[axis] = LOW[axis],
            1 => position[axis] = HIGH[axis],
            2 => position[axis] = HIGH[axis] + other[3],
            3 => position[axis] = LOW[axis] - other[3],
            _ => {}
        }
        let mut normal = warp::sphere([other[0], other[1]]);
        if index.is_multiple_of(2) {
            normal = Vec3::ZERO;
            normal[axis] = if other[2] < 0.5 { 1.0 } else { -1.0 };
        }
        let radius = [1e-6, 0.01, 0.1, 0.3, 1.0, 4.0, 100.0][(index / 7 % 7) as usize];
        let most_segments = if index.is_multiple_of(3) { 12 } else { 127 };
        GatherQuery {
            position,
            normal,
            radius_squared: radius * radius,
            most_segments,
            caustics_only: index.is_multiple_of(2),
            both_sides: false,
        }
    };
    (0..count).map(query).collect()
}

fn build(photons: &[Photon], cell: f32, most_cells: u64) -> PhotonMap {
    let grid = Grid::new(LOW, HIGH, cell, most_cells);
    // Chunks of different lengths, as passes have.
    let chunks: Vec<PhotonChunk> = photons.chunks(777).map(|chunk| PhotonChunk::sort(chunk, &grid)).collect();
    PhotonMap::build(&chunks, grid)
}

/// Photons that are looked through one by one: the definition of what counts, and the second structure that can be looked up.
struct Listed<'a>(&'a [Photon]);

impl Listed<'_> {
    /// Squared distance, in space, of the photons with normals that agree to 0.7 and within the limit on segments; and their
    /// height over the tangent plane.
    fn seen(&self, query: &GatherQuery) -> impl Iterator<Item = (usize, f32, f32)> {
        self.0.iter().enumerate().filter_map(|(index, photon)| {
            let offset = Vec3::from_array(photon.position) - query.position;
            let byte = |shift: u32| f32::from((photon.normal_and_segments >> shift) as u8 as i8) / 127.0;
            let cosine = Vec3::new(byte(0), byte(8), byte(16)).dot(query.normal);
            let counts = cosine > 0.7
                && photon.normal_and_segments >> 24 & 0x7f <= query.most_segments
                && !(query.caustics_only && photon.normal_and_segments >> 31 == 1);
            counts.then(|| (index, offset.length_squared(), offset.dot(query.normal).abs()))
        })
    }
}

impl PhotonLookup for Listed<'_> {
    /// In the ball, and within a quarter of the radius of the tangent plane.
    fn visit_disc(&self, query: &GatherQuery, mut visit: impl FnMut(usize, bool)) {
        for (index, distance_squared, height) in self.seen(query) {
            if distance_squared < query.radius_squared && height <= 0.25 * query.radius_squared.sqrt() {
                visit(index, distance_squared < 0.5 * query.radius_squared);
            }
        }
    }

    fn nearest(&self, query: &GatherQuery, count: usize, found: &mut Nearest) {
        found.begin(query.radius_squared);
        for (index, distance_squared, height) in self.seen(query) {
            let distance_squared = distance_squared.max(16.0 * height * height);
            if distance_squared < query.radius_squared {
                found.take(distance_squared, index);
            }
        }
        found.end(count);
    }

    fn photon(&self, index: usize) -> Photon {
        self.0[index]
    }

    fn len(&self) -> usize {
        self.0.len()
    }

    fn bytes(&self) -> usize {
        size_of_val(self.0)
    }
}

/// What a look-up shows of a disc, one photon at a time.
fn shown(photons: &impl PhotonLookup, query: &GatherQuery) -> (f64, [f64; 3]) {
    let (mut count, mut flux) = (0.0, [0.0; 3]);
    photons.visit_disc(query, |index, _| {
        count += 1.0;
        (0..3).for_each(|channel| flux[channel] += f64::from(photons.photon(index).flux[channel]));
    });
    (count, flux)
}

fn assert_same_flux(found: Rgb, expected: [f64; 3], query: &GatherQuery) {
    for channel in 0..3 {
        let difference = (f64::from(found[channel]) - expected[channel]).abs();
        assert!(difference <= 1e-5 * expected[channel], "{found} is not {expected:?} for {query:?}");
    }
}

#[test]
fn agreement_gather_equals_its_plain_twin_and_a_full_search() {
    let photons = cloud(1, 20_000);
    // From one cell to many more than photons.
    for (cell, most_cells) in [(10.0, 1), (0.5, 1 << 20), (0.05, 1 << 20), (0.01, 1 << 22), (0.001, 5000)] {
        let map = build(&photons, cell, most_cells);
        assert_eq!(map.len(), photons.len());
        let (mut found, mut empty) = (0, 0);
        for query in queries(&photons, 1, 700) {
            let gathered = map.gather(&query);
            let (count, flux) = shown(&map, &query);
            assert_eq!(f64::from(gathered.photons), count, "{query:?}");
            assert_same_flux(gathered.flux, flux, &query);
            let (all, all_flux) = shown(&Listed(&photons), &query);
            assert_eq!(count, all, "cells of {cell}: {query:?}");
            assert_same_flux(gathered.flux, all_flux, &query);
            let listed = Listed(&photons).gather(&query);
            assert_eq!(listed.photons, gathered.photons);
            let difference = (listed.inner_flux - gathered.inner_flux).abs().max_element();
            assert!(difference <= 1e-3 * gathered.inner_flux.max_element(), "{query:?}");
            if count > 0.0 { found += 1 } else { empty += 1 }
        }
        assert!(found > 200 && empty > 50, "{found} queries found photons and {empty} none: the test is one-sided");
    }
}

#[test]
fn agreement_nearest_photons_are_those_of_a_full_search() {
    let photons = cloud(5, 5000);
    let (mut of_map, mut of_list) = (Nearest::default(), Nearest::default());
    let mut most = 0;
    for cell in [10.0, 0.3, 0.02] {
        let map = build(&photons, cell, 1 << 20);
        for query in queries(&photons, 5, 300) {
            map.nearest(&query, 12, &mut of_map);
            Listed(&photons).nearest(&query, 12, &mut of_list);
            assert_eq!(of_map.photons().len(), of_list.photons().len(), "{query:?}");
            let (one, other) = (of_map.radius_squared(), of_list.radius_squared());
            assert!((one / other - 1.0).abs() < 1e-4, "{one} is not {other}: {query:?}");
            most = most.max(of_map.photons().len());
        }
    }
    assert_eq!(most, 11, "the twelfth gives the radius and does not count");
}

#[test]
fn agreement_of_a_kd_tree_and_a_full_search() {
    let (mut of_tree, mut of_list) = (Nearest::default(), Nearest::default());
    for count in [1, 8, 9, 100, 20_000] {
        let photons = cloud(7, count);
        let tree = KdTree::build(photons.clone());
        assert_eq!(tree.len(), photons.len());
        for query in queries(&photons, 7, 700) {
            let both_sides = GatherQuery { both_sides: true, ..query };
            let (found, flux) = shown(&tree, &query);
            let (all, all_flux) = shown(&Listed(&photons), &query);
            assert_eq!(found, all, "{count} photons: {query:?}");
            assert_same_flux(tree.gather(&query).flux, all_flux, &query);
            assert_same_flux(Rgb::from_array(flux.map(|channel| channel as f32)), all_flux, &query);
            assert!(shown(&tree, &both_sides).0 >= found);
            tree.nearest(&query, 12, &mut of_tree);
            Listed(&photons).nearest(&query, 12, &mut of_list);
            assert_eq!(of_tree.photons().len(), of_list.photons().len(), "{query:?}");
            let (one, other) = (of_tree.radius_squared(), of_list.radius_squared());
            assert!((one / other - 1.0).abs() < 1e-4, "{one} is not {other}: {query:?}");
        }
    }
}

/// The tree is the same in whatever order photons come, and for any number of threads.
#[test]
fn a_kd_tree_depends_on_the_photons_alone() {
    let photons = cloud(8, 40_000);
    let mut turned = photons.clone();
    turned.reverse();
    turned.rotate_left(777);
    let tree = |photons: &[Photon], threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool can be made");
        let tree = pool.install(|| KdTree::build(photons.to_vec()));
        (0..tree.len()).map(|index| tree.photon(index)).collect::<Vec<_>>()
    };
    let one = tree(&photons, 1);
    assert_eq!(one, tree(&turned, 1));
    assert_eq!(one, tree(&photons, 4));
}

#[test]
fn small_records_keep_photons_within_their_precision() {
    assert_eq!(size_of::<CompactPhoton>(), 20);
    for photon in cloud(9, 10_000) {
        let kept = CompactPhoton::from(&photon).unpacked();
        assert_eq!(kept.position, photon.position);
        assert_eq!((kept.segments(), kept.is_scattered()), (photon.segments(), photon.is_scattered()));
        let angle = |a: Vec3, b: Vec3| a.normalize().dot(b.normalize()).clamp(-1.0, 1.0).acos();
        let turned = angle(octahedral::decode(kept.direction), octahedral::decode(photon.direction));
        assert!(turned < 0.02, "a direction is {turned} rad off");
        let tilted = angle(kept.normal(), photon.normal());
        assert!(tilted < 0.3, "a normal is {tilted} rad off");
        let largest = photon.flux.into_iter().fold(0.0, f32::max);
        for (kept, flux) in kept.flux.into_iter().zip(photon.flux) {
            // The largest channel has a mantissa of at least 128 steps, or 127.5 at most where rounding would overflow.
            assert!((kept - flux).abs() <= largest / 127.0, "{kept} for {flux} beside {largest}");
        }
    }
}

#[test]
fn a_map_takes_32_bytes_a_photon_and_4_a_cell() {
    let photons = cloud(6, 10_000);
    assert_eq!(Listed(&photons).bytes(), 320_000);
    let map = build(&photons, 0.5, 1 << 20);
    let cells = Grid::new(LOW, HIGH, 0.5, 1 << 20).cell_count();
    // The columns are padded to whole groups of eight.
    assert_eq!(map.bytes(), 32 * (10_000 + 8) + 4 * (cells + 1));
}

#[test]
fn agreement_photons_on_the_border_are_found() {
    // On every face, edge and corner of the box, and next to them on either side by rounding.
    let mut photons = Vec::new();
    for code in 0..27u32 {
        let digit = |axis: usize| code / 3u32.pow(axis as u32) % 3;
        let mut position = (LOW + HIGH) * 0.5;
        for axis in 0..3 {
            position[axis] = [LOW[axis], position[axis], HIGH[axis]][digit(axis) as usize];
        }
        for nudge in [1.0, 1.0 - f32::EPSILON, 1.0 + f32::EPSILON] {
            photons.push(Photon::new(position * nudge, 0, Vec3::Z, Rgb::ONE, 1, false));
        }
    }
    for cell in [0.001, 0.0317, 0.3, 0.75, 5.0] {
        let map = build(&photons, cell, 1 << 22);
        for photon in &photons {
            let position = Vec3::from_array(photon.position);
            let query = GatherQuery {
                position,
                normal: Vec3::Z,
                radius_squared: 1e-8,
                most_segments: 127,
                caustics_only: false,
                both_sides: false,
            };
            assert_eq!(map.gather(&query).photons, 3.0, "cells of {cell}: photon at {position}");
        }
    }
}

#[test]
fn agreement_of_an_empty_map_and_a_flat_box() {
    let map = build(&[], 0.1, 1 << 20);
    assert!(map.is_empty());
    for query in queries(&cloud(2, 10), 2, 100) {
        assert_eq!(map.gather(&query), Gathered::default());
    }
    // A floor alone: a grid without height.
    let grid = Grid::new(Vec3::ZERO, Vec3::new(1.0, 0.0, 1.0), 0.01, 1 << 20);
    let floor = |index| {
        let u = uniform(3, index, 0);
        Photon::new(Vec3::new(u[0], 0.0, u[1]), 0, Vec3::Y, Rgb::ONE, 1, false)
    };
    let photons: Vec<Photon> = (0..1000).map(floor).collect();
    let map = PhotonMap::build(&[PhotonChunk::sort(&photons, &grid)], grid);
    let query = GatherQuery {
        position: Vec3::new(0.5, 0.0, 0.5),
        normal: Vec3::Y,
        radius_squared: 2.0,
        most_segments: 127,
        caustics_only: false,
        both_sides: false,
    };
    assert_eq!(map.gather(&query).photons, 1000.0);
}

#[test]
fn agreement_of_maps_built_by_one_and_by_four_threads() {
    let photons = cloud(4, 30_000);
    let gathers = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool can be made");
        let map = pool.install(|| build(&photons, 0.07, 1 << 20));
        let gathered: Vec<Gathered> = queries(&photons, 4, 1000).iter().map(|query| map.gather(query)).collect();
        gathered.iter().map(|g| [g.flux.x, g.flux.y, g.flux.z, g.photons].map(f32::to_bits)).collect::<Vec<_>>()
    };
    let one = gathers(1);
    assert_eq!(one, gathers(4));
    assert_eq!(one, gathers(3));
}
