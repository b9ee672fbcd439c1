//! Crop windows show a part of the whole film; filters spread camera paths as they weigh.

use crate::scene_text::prepare;
use photonfarm::math::Vec2;
use photonfarm::scene::{Scene, SceneError};

fn with_film(film: &str) -> Result<Scene, SceneError> {
    let body = format!("<sensor type='perspective'><film type='hdrfilm'>{film}</film></sensor>");
    prepare(&format!("{body}<emitter type='point'/><shape type='cube'/>"), &[])
}

fn scene(film: &str) -> Scene {
    with_film(film).unwrap_or_else(|error| panic!("{film}: {error}"))
}

fn integers(numbers: &[(&str, i32)]) -> String {
    numbers.iter().map(|(name, number)| format!("<integer name='{name}' value='{number}'/>")).collect()
}

#[test]
fn analytic_crop_windows_are_parts_of_the_film() {
    const BORDER: &str = "<boolean name='sample_border' value='true'/>";
    let whole = scene(&[&integers(&[("width", 60), ("height", 40)]), BORDER].concat());
    let window = [("crop_offset_x", 13), ("crop_offset_y", 7), ("crop_width", 20), ("crop_height", 9)];
    let part = integers(&[[("width", 60), ("height", 40)].as_slice(), window.as_slice()].concat());
    let part = scene(&[&part, BORDER].concat());
    assert_eq!((part.width, part.height), (20, 9));
    for pixel in [[0, 0], [19, 8], [4, 6]] {
        let numbers = [0.25, 0.875, 0.5, 0.5];
        let [one, other] = [part.camera_ray(pixel, numbers), whole.camera_ray([pixel[0] + 13, pixel[1] + 7], numbers)];
        assert_eq!((one.origin, one.direction), (other.origin, other.direction));
    }
    let rest = scene(&integers(&[("width", 60), ("height", 40), ("crop_offset_x", 50)]));
    assert_eq!((rest.width, rest.height), (10, 40));
}

#[test]
fn analytic_filters_have_their_width() {
    let variance = |film: &str| {
        let film = scene(film).film;
        let places = (0..100_000).map(|index| f64::from(film.filter.sample((index as f32 + 0.5) / 100_000.0).0) - 0.5);
        let (sum, squares) = places.fold((0.0, 0.0), |(sum, squares), x| (sum + x, squares + x * x));
        assert!((sum / 1e5).abs() < 1e-3, "{sum}");
        squares / 1e5
    };
    let gaussian = "<rfilter type='gaussian'><float name='stddev' value='0.8'/></rfilter>";
    for (film, expected) in [
        ("", 0.25),
        ("<rfilter type='box'/>", 1.0 / 12.0),
        ("<rfilter type='box'><float name='radius' value='1.5'/></rfilter>", 9.0 / 12.0),
        ("<rfilter type='tent'/>", 1.0 / 6.0),
        ("<rfilter type='tent'><float name='radius' value='2'/></rfilter>", 4.0 / 6.0),
        ("<rfilter type='gaussian'/>", 0.25),
        (gaussian, 0.64),
    ] {
        let found = variance(film);
        // The gaussian ends at 4 σ.
        assert!((found / expected - 1.0).abs() < 0.01, "{film}: variance {found}, not {expected}");
    }
}

#[test]
fn analytic_film_points_start_at_the_top_left() {
    let scene = scene(&format!("{}<rfilter type='box'/>", integers(&[("width", 8), ("height", 4)])));
    assert_eq!(scene.film.point([0, 0], [0.0, 0.0]), (Vec2::ZERO, 1.0));
    assert_eq!(scene.film.smooth_point([7, 1], [0.5, 0.5]), Vec2::new(7.5 / 8.0, 1.5 / 4.0));
}

#[test]
fn analytic_films_that_cannot_be() {
    let size = integers(&[("width", 60), ("height", 40)]);
    for (film, part) in [
        (integers(&[("crop_offset_x", 60)]), "from 0 to 59"),
        (integers(&[("crop_offset_y", -1)]), "from 0 to 39"),
        (integers(&[("crop_offset_y", 30), ("crop_height", 11)]), "at most 10"),
        (integers(&[("crop_width", 0)]), "at least 1"),
        ("<rfilter type='tent'><float name='radius' value='0'/></rfilter>".to_owned(), "above 0"),
        ("<rfilter type='tent'><float name='radius' value='1e9'/></rfilter>".to_owned(), "up to 64"),
        ("<rfilter type='mitchell'><float name='B' value='2'/></rfilter>".to_owned(), "from 0 to 1"),
        ("<rfilter type='lanczos'><integer name='lobes' value='0'/></rfilter>".to_owned(), "from 1 to 16"),
        ("<rfilter type='gausian'/>".to_owned(), "did you mean \"gaussian\"?"),
    ] {
        let message = with_film(&format!("{size}{film}")).err().unwrap_or_else(|| panic!("{film} is fine")).to_string();
        assert!(message.contains(part), "{film}: {message}");
    }
}
