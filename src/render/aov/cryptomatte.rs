//! Cryptomatte layers: identifiers of what a pixel sees, with the share of its light that each brings
//! (Friedman & Jones 2015, "Fully Automatic ID Mattes with Support for Motion Blur and Transparency";
//! Cryptomatte specification 1.2.0).
//!
//! The shares include all that blurs: the lens out of focus, motion and the edges of shapes. The rest of a pixel
//! is its background.

use std::collections::{BTreeMap, HashMap};

use super::coverage::Coverage;
use petzval_image::{ImageLayer, Note, Notes};
use petzval_scene::{PlacedShape, Scene};

/// Largest number of identifiers in a pixel. A channel pair holds each, a layer of four channels two.
const RANKS: usize = 6;
const RANKS_PER_LAYER: usize = 2;
/// Number of channels of each kind of matte.
pub(super) const CHANNELS: usize = 2 * RANKS;
/// Number of kinds of mattes.
pub(super) const KINDS: usize = Kind::ALL.len();

/// Parts of a scene that identifiers name.
#[derive(Clone, Copy, Debug)]
enum Kind {
    /// A shape in its place.
    Object,
    /// A material.
    Material,
    /// An object that all its instances share, or a shape outside objects.
    Asset,
}

impl Kind {
    const ALL: [Self; 3] = [Self::Object, Self::Material, Self::Asset];

    /// Returns the name of the layers, without their numbers.
    fn layer(self) -> &'static str {
        match self {
            Self::Object => "CryptoObject",
            Self::Material => "CryptoMaterial",
            Self::Asset => "CryptoAsset",
        }
    }

    /// Returns the names of the attributes: the layers' name, its hash, the conversion and the manifest. Their
    /// middle part is the beginning of the hash of the layers' name.
    fn attributes(self) -> [&'static str; 4] {
        match self {
            Self::Object => [
                "cryptomatte/3ae39a5/name",
                "cryptomatte/3ae39a5/hash",
                "cryptomatte/3ae39a5/conversion",
                "cryptomatte/3ae39a5/manifest",
            ],
            Self::Material => [
                "cryptomatte/be359d6/name",
                "cryptomatte/be359d6/hash",
                "cryptomatte/be359d6/conversion",
                "cryptomatte/be359d6/manifest",
            ],
            Self::Asset => [
                "cryptomatte/f42029d/name",
                "cryptomatte/f42029d/hash",
                "cryptomatte/f42029d/conversion",
                "cryptomatte/f42029d/manifest",
            ],
        }
    }

    /// Returns the name of the part of this kind that a shape belongs to.
    fn name(self, scene: &Scene, placed: PlacedShape) -> String {
        match self {
            Self::Object => scene.placed_name(placed),
            Self::Material => {
                let material = scene.shapes[placed.shape as usize].material;
                scene.names.material(material).into_owned()
            }
            Self::Asset => scene.asset_name(placed).into_owned(),
        }
    }
}

/// Returns the layers of all kinds. `pixels` returns the weights of each pixel's shapes, and the sum of the weights
/// of all its paths.
pub(super) fn layers<'a, I>(scene: &Scene, pixels: impl Fn() -> I) -> Vec<ImageLayer>
where
    I: ExactSizeIterator<Item = (&'a Coverage, f64)>,
{
    Kind::ALL.into_iter().flat_map(|kind| layers_of(kind, scene, pixels())).collect()
}

fn layers_of<'a>(
    kind: Kind,
    scene: &Scene,
    pixels: impl ExactSizeIterator<Item = (&'a Coverage, f64)>,
) -> Vec<ImageLayer> {
    let mut channels = vec![vec![0.0_f32; pixels.len()]; CHANNELS];
    let mut known: HashMap<PlacedShape, u32> = HashMap::new();
    let mut manifest = BTreeMap::new();
    for (pixel, (coverage, total)) in pixels.enumerate() {
        let sums = coverage.by_id(|placed| {
            *known.entry(placed).or_insert_with(|| {
                let name = kind.name(scene, placed);
                let id = identifier(&name);
                manifest.insert(name, id);
                id
            })
        });
        let mut ranked: Vec<(u32, f64)> = sums.into_iter().filter(|(_, sum)| *sum > 0.0).collect();
        // A stable order: equal shares stay in the order of identifiers.
        ranked.sort_by(|(_, a), (_, b)| b.total_cmp(a));
        for (rank, (id, sum)) in ranked.into_iter().take(RANKS).enumerate() {
            channels[2 * rank][pixel] = f32::from_bits(id);
            channels[2 * rank + 1][pixel] = (sum / total).min(1.0) as f32;
        }
    }
    let mut channels = channels.into_iter();
    let mut layer = |number: usize| ImageLayer {
        name: format!("{}{number:02}", kind.layer()),
        channels: ["R", "G", "B", "A"].map(str::to_owned).into_iter().zip(&mut channels).collect(),
        notes: Notes::new(),
    };
    let mut layers: Vec<_> = (0..RANKS / RANKS_PER_LAYER).map(&mut layer).collect();
    layers[0].notes = notes(kind, &manifest);
    layers
}

/// Returns the attributes by which a compositor finds the layers of a kind, and the names in them.
fn notes(kind: Kind, manifest: &BTreeMap<String, u32>) -> Notes {
    let manifest: serde_json::Map<String, serde_json::Value> =
        manifest.iter().map(|(name, id)| (name.clone(), format!("{id:08x}").into())).collect();
    let texts = [
        kind.layer().to_owned(),
        "MurmurHash3_32".to_owned(),
        "uint32_to_float32".to_owned(),
        ascii_json(&serde_json::Value::Object(manifest).to_string()),
    ];
    kind.attributes().into_iter().zip(texts.map(Note::Text)).collect()
}

/// Returns a text of JSON in which characters other than ASCII are escaped, as attributes of EXR files hold bytes.
fn ascii_json(json: &str) -> String {
    let mut result = String::with_capacity(json.len());
    for character in json.chars() {
        match character.is_ascii() {
            true => result.push(character),
            false => {
                for unit in character.encode_utf16(&mut [0; 2]) {
                    result.push_str(&format!("\\u{unit:04x}"));
                }
            }
        }
    }
    result
}

/// Returns the identifier of a name: its hash, as the bits of a normal float. A hash that would be none has the
/// lowest bit of its exponent turned.
fn identifier(name: &str) -> u32 {
    let hash = murmur3_32(name.as_bytes());
    match hash >> 23 & 0xff {
        0 | 0xff => hash ^ 1 << 23,
        _ => hash,
    }
}

/// Returns the hash `MurmurHash3_x86_32` of Austin Appleby with the seed 0.
fn murmur3_32(bytes: &[u8]) -> u32 {
    let scramble =
        |word: u32| word.wrapping_mul(0xcc9e_2d51).rotate_left(15).wrapping_mul(0x1b87_3593);
    let mut hash = 0_u32;
    let (words, rest) = bytes.as_chunks::<4>();
    for word in words {
        hash ^= scramble(u32::from_le_bytes(*word));
        hash = hash.rotate_left(13).wrapping_mul(5).wrapping_add(0xe654_6b64);
    }
    let tail = rest.iter().rev().fold(0, |tail, &byte| tail << 8 | u32::from(byte));
    hash ^= scramble(tail);
    hash ^= bytes.len() as u32;
    for (shift, factor) in [(16, 0x85eb_ca6b), (13, 0xc2b2_ae35)] {
        hash = (hash ^ hash >> shift).wrapping_mul(factor);
    }
    hash ^ hash >> 16
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hashes_are_those_of_the_reference() {
        // mmh3 5.2, PyPI.
        let known = [
            ("", 0),
            ("a", 0x3c25_69b2),
            ("ab", 0x9bbf_d75f),
            ("abc", 0xb3dd_93fa),
            ("hello", 0x248b_fa47),
            ("hero", 0x82ce_30b4),
        ];
        for (text, hash) in known {
            assert_eq!(murmur3_32(text.as_bytes()), hash, "{text}");
        }
        for kind in Kind::ALL {
            let key = &format!("{:08x}", murmur3_32(kind.layer().as_bytes()))[..7];
            for name in kind.attributes() {
                assert_eq!(name.split('/').nth(1), Some(key));
            }
        }
    }

    #[test]
    fn identifiers_are_normal_floats() {
        for i in 0..100_000 {
            let value = f32::from_bits(identifier(&i.to_string()));
            assert!(value.is_normal(), "{i}");
        }
    }
}
