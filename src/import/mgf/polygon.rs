//! Polygons as triangles, by clipping ears [Meisters 1975; Eberly 2008]: concave ones, ones with seams, and ones with
//! holes.

use glam::{DVec2, DVec3};

/// A polygon that was cut up.
pub(super) struct Triangulation {
    /// Unit normal by the right-hand rule.
    pub normal: DVec3,
    /// Indices into the loops' points, one loop after the other.
    pub triangles: Vec<[usize; 3]>,
    /// Whether its outline crosses itself, so that the triangles are a guess.
    pub crossing: bool,
}

/// Why a polygon has no triangles.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Failure {
    /// It has no area.
    Flat,
    /// Polygons of the scene have taken more work than anyone would wait for.
    Costly,
}

/// Cuts up the polygon with the outline `loops[0]` and holes in the others. `work` counts down steps, of which all
/// polygons of a scene share a store.
pub(super) fn triangulate(loops: &[Vec<DVec3>], work: &mut u64) -> Result<Triangulation, Failure> {
    let outline = loops.first().ok_or(Failure::Flat)?;
    let normal = area_vector(outline).try_normalize().ok_or(Failure::Flat)?;
    let points: Vec<DVec2> = loops.iter().flatten().map(|point| flatten(*point, normal)).collect();
    if let ([_], Some(triangles)) = (loops, fan(&points)) {
        return Ok(Triangulation { normal, triangles, crossing: false });
    }
    let mut ring: Vec<usize> = (0..outline.len()).collect();
    let mut start = outline.len();
    let mut holes = Vec::new();
    for hole in &loops[1..] {
        let mut indices: Vec<usize> = (start..start + hole.len()).collect();
        start += hole.len();
        // A hole runs the other way round.
        if area_vector(hole).dot(normal) > 0.0 {
            indices.reverse();
        }
        holes.push(indices);
    }
    for at in 0..holes.len() {
        join(&mut ring, &holes[at..], &points, work)?;
    }
    let (triangles, crossing) = clip_ears(&points, &ring, work)?;
    if triangles.is_empty() { Err(Failure::Flat) } else { Ok(Triangulation { normal, triangles, crossing }) }
}

/// A vector along the normal, twice as long as the polygon's area.
fn area_vector(outline: &[DVec3]) -> DVec3 {
    let Some(first) = outline.first() else { return DVec3::ZERO };
    outline.windows(2).map(|pair| (pair[0] - *first).cross(pair[1] - *first)).sum()
}

/// Drops the axis that `normal` is nearest to; counter-clockwise round the normal stays counter-clockwise.
fn flatten(point: DVec3, normal: DVec3) -> DVec2 {
    let size = normal.abs();
    let axis = if size.z >= size.x.max(size.y) { 2 } else { usize::from(size.y > size.x) };
    let (u, v) = (point[(axis + 1) % 3], point[(axis + 2) % 3]);
    if normal[axis] > 0.0 { DVec2::new(u, v) } else { DVec2::new(v, u) }
}

/// Twice the signed area of a triangle.
fn turn(a: DVec2, b: DVec2, c: DVec2) -> f64 {
    (b - a).perp_dot(c - a)
}

/// Triangles round the first point, if the polygon is convex.
fn fan(points: &[DVec2]) -> Option<Vec<[usize; 3]>> {
    let count = points.len();
    let corner = |at: usize| turn(points[at], points[(at + 1) % count], points[(at + 2) % count]);
    let slice = |at: usize| turn(points[0], points[at], points[at + 1]);
    let convex = (0..count).all(|at| corner(at) >= 0.0) && (1..count - 1).all(|at| slice(at) >= 0.0);
    let triangles = || (1..count - 1).filter(|at| slice(*at) > 0.0).map(|at| [0, at, at + 1]).collect();
    convex.then(triangles)
}

/// Makes the first hole part of the outline by a seam from one of its corners to the nearest one of the outline that sees
/// it past all of the holes.
fn join(ring: &mut Vec<usize>, holes: &[Vec<usize>], points: &[DVec2], work: &mut u64) -> Result<(), Failure> {
    let hole = &holes[0];
    let Some(from) = hole.iter().copied().max_by(|a, b| points[*a].x.total_cmp(&points[*b].x)) else { return Ok(()) };
    let mut candidates: Vec<usize> = (0..ring.len()).collect();
    let distance = |place: usize| points[ring[place]].distance_squared(points[from]);
    candidates.sort_by(|a, b| distance(*a).total_cmp(&distance(*b)));
    let mut seam = candidates.first().copied().unwrap_or_default();
    for place in candidates {
        *work = work.checked_sub((ring.len() + points.len()) as u64).ok_or(Failure::Costly)?;
        let mut edges = edges(ring).chain(holes.iter().flat_map(|hole| edges(hole)));
        if !edges.any(|edge| cross(points, (from, ring[place]), edge)) {
            seam = place;
            break;
        }
    }
    let first = hole.iter().position(|index| *index == from).unwrap_or_default();
    let around = hole[first..].iter().chain(&hole[..=first]).copied();
    let insertion: Vec<usize> = around.chain([ring[seam]]).collect();
    ring.splice(seam + 1..seam + 1, insertion);
    Ok(())
}

fn edges(ring: &[usize]) -> impl Iterator<Item = (usize, usize)> + '_ {
    ring.iter().copied().zip(ring.iter().copied().cycle().skip(1))
}

/// Whether two segments without a common end cross or touch.
fn cross(points: &[DVec2], one: (usize, usize), other: (usize, usize)) -> bool {
    let [a, b, c, d] = [one.0, one.1, other.0, other.1].map(|index| points[index]);
    if a == c || a == d || b == c || b == d {
        return false;
    }
    turn(a, b, c) * turn(a, b, d) <= 0.0 && turn(c, d, a) * turn(c, d, b) <= 0.0
}

/// The triangles of a ring of points, and whether some had to be guessed.
fn clip_ears(points: &[DVec2], ring: &[usize], work: &mut u64) -> Result<(Vec<[usize; 3]>, bool), Failure> {
    let count = ring.len();
    let mut next: Vec<usize> = (1..=count).map(|at| at % count).collect();
    let mut previous: Vec<usize> = (0..count).map(|at| (at + count - 1) % count).collect();
    let mut triangles = Vec::with_capacity(count);
    let (mut left, mut tried, mut at, mut crossing) = (count, 0, 0, false);
    while left >= 3 {
        *work = work.checked_sub(left as u64).ok_or(Failure::Costly)?;
        let (before, after) = (previous[at], next[at]);
        let corner = [before, at, after].map(|place| ring[place]);
        let area = turn(points[corner[0]], points[corner[1]], points[corner[2]]);
        let forced = tried >= left;
        if forced || is_ear(points, ring, &next, [before, at, after], area) {
            crossing |= forced;
            if area > 0.0 {
                triangles.push(corner);
            }
            (next[before], previous[after]) = (after, before);
            (left, tried) = (left - 1, 0);
        } else {
            tried += 1;
        }
        at = after;
    }
    Ok((triangles, crossing))
}

fn is_ear(points: &[DVec2], ring: &[usize], next: &[usize], corner: [usize; 3], area: f64) -> bool {
    let [a, b, c] = corner.map(|place| points[ring[place]]);
    // What has no area can always go.
    if area <= 0.0 {
        return area == 0.0;
    }
    let mut place = next[corner[2]];
    while place != corner[0] {
        let point = points[ring[place]];
        let elsewhere = point != a && point != b && point != c;
        if elsewhere && turn(a, b, point) >= 0.0 && turn(b, c, point) >= 0.0 && turn(c, a, point) >= 0.0 {
            return false;
        }
        place = next[place];
    }
    true
}

#[cfg(test)]
mod tests {
    use super::{Failure, triangulate};
    use glam::DVec3;

    fn area(loops: &[Vec<DVec3>]) -> f64 {
        let cut = triangulate(loops, &mut 1_000_000).expect("it has triangles");
        assert!(!cut.crossing);
        let points: Vec<DVec3> = loops.concat();
        let vector = |[a, b, c]: [usize; 3]| (points[b] - points[a]).cross(points[c] - points[a]);
        assert!(cut.triangles.iter().all(|triangle| vector(*triangle).dot(cut.normal) > 0.0), "a triangle is turned");
        cut.triangles.iter().map(|triangle| 0.5 * vector(*triangle).length()).sum()
    }

    fn square(center: [f64; 2], half: f64) -> Vec<DVec3> {
        let corner = |x: f64, y: f64| DVec3::new(0.0, center[0] + half * x, center[1] + half * y);
        vec![corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)]
    }

    #[test]
    fn analytic_areas_of_polygons() {
        let comb: Vec<DVec3> =
            [(0, 0), (5, 0), (5, 3), (4, 3), (4, 1), (3, 1), (3, 3), (2, 3), (2, 1), (1, 1), (1, 3), (0, 3)]
                .map(|(x, y)| DVec3::new(f64::from(x), f64::from(y), 1.0))
                .to_vec();
        assert!((area(std::slice::from_ref(&comb)) - 11.0).abs() < 1e-12);
        let turned: Vec<DVec3> = comb.iter().rev().map(|point| DVec3::new(point.z, point.x, point.y)).collect();
        assert!((area(&[turned]) - 11.0).abs() < 1e-12);
        let holes =
            [square([0.0, 0.0], 3.0), square([-1.5, 0.0], 0.5), square([1.5, 1.0], 0.5), square([1.5, -1.0], 0.5)];
        assert!((area(&holes) - 33.0).abs() < 1e-12);
        // The same with one hole by a seam, as the format's first version writes it.
        let [outer, hole, ..] = holes;
        let seam = [&outer[..], &[hole[3], hole[2], hole[1], hole[0], hole[3], outer[3]]].concat();
        assert!((area(&[seam]) - 35.0).abs() < 1e-12);
        let flat = vec![DVec3::ZERO, DVec3::X, DVec3::X * 2.0];
        assert_eq!(triangulate(&[flat], &mut 100).err(), Some(Failure::Flat));
        assert_eq!(triangulate(&[comb], &mut 5).err(), Some(Failure::Costly));
    }
}
