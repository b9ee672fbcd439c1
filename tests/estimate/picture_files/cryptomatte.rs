//! Ids of names, as the specification of Cryptomatte says them.

use photonfarm::estimate::picture_files::{murmur3, name_id};

/// What the hash's users publish, and the examples of the specification.
#[test]
fn hashes_are_the_published_ones() {
    let known: [(&str, u32, u32); 8] = [
        ("", 0, 0),
        ("", 1, 0x514e_28b7),
        ("", 0xffff_ffff, 0x81f1_6f39),
        ("test", 0, 0xba6b_d213),
        ("Hello, world!", 0, 0xc036_3e43),
        ("The quick brown fox jumps over the lazy dog", 0, 0x2e4f_f723),
        ("torus", 0, 4_053_562_365),
        ("равнина", 0, 2_518_896_926),
    ];
    for (text, seed, hash) in known {
        assert_eq!(murmur3(text.as_bytes(), seed), hash, "{text}");
    }
}

#[test]
fn ids_are_the_bits_of_hashes_and_good_floats() {
    assert_eq!((name_id("torus"), name_id("равнина")), (-1.549_436_2e30, -1.319_263_1e-25));
    assert_eq!((name_id("bunny").to_bits(), name_id("default").to_bits()), (0x1385_1a76, 0x42c9_679f));
    // Their hashes have exponents of 0 and 255: less than full precision, and not a number.
    for (name, hash, id) in [("shape 274", 0x807f_eca9, 0x80ff_eca9), ("shape 404", 0xffbe_d3d6_u32, 0xff3e_d3d6)] {
        assert_eq!((murmur3(name.as_bytes(), 0), name_id(name).to_bits()), (hash, id), "{name}");
        assert!(name_id(name).is_normal(), "{name}");
    }
    assert!((0..20_000).all(|index| name_id(&format!("shape {index}")).is_normal()));
}
