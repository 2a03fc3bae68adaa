//! Conversion of finished layers to another frame or colour space.

use glam::{DAffine3, DMat3, DVec3};

use super::Aov;
use petzval_image::ImageLayer;

/// Converts the layers of positions and normals from world space to camera space. Pixels without a
/// surface, of which all channels are 0, stay 0.
pub fn to_camera(layers: &mut [ImageLayer], camera_from_world: &DAffine3) {
    let normal_matrix = camera_from_world.matrix3.inverse().transpose();
    for layer in layers {
        if layer.name == Aov::Position.name() {
            convert(layer, |position| camera_from_world.transform_point3(position));
        } else if layer.name == Aov::Normal.name() {
            convert(layer, |normal| (normal_matrix * normal).normalize_or_zero() * normal.length());
        }
    }
}

/// Converts the layers of these names from linear sRGB to another space.
pub fn convert_colours(layers: &mut [ImageLayer], names: &[&str], from_srgb: &DMat3) {
    for layer in layers.iter_mut().filter(|layer| names.contains(&layer.name.as_str())) {
        convert(layer, |colour| *from_srgb * colour);
    }
}

/// Converts the vectors of a layer of three channels that are not 0.
fn convert(layer: &mut ImageLayer, to: impl Fn(DVec3) -> DVec3) {
    let [(_, x), (_, y), (_, z)] = &mut layer.channels[..] else { return };
    for ((x, y), z) in x.iter_mut().zip(y).zip(z) {
        let vector = DVec3::new((*x).into(), (*y).into(), (*z).into());
        if vector != DVec3::ZERO {
            [*x, *y, *z] = to(vector).to_array().map(|v| v as f32);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layer(aov: Aov, vectors: [[f32; 3]; 2]) -> ImageLayer {
        let channel = |i: usize| (format!("{i}"), vectors.iter().map(|v| v[i]).collect());
        ImageLayer::new(aov.name(), (0..3).map(channel).collect())
    }

    fn first(layer: &ImageLayer) -> [f32; 3] {
        [0, 1, 2].map(|i| layer.channels[i].1[0])
    }

    #[test]
    fn positions_move_normals_turn_and_empty_pixels_stay() {
        // The camera is at (0, 0, 5), and sees scenes at half their size.
        let matrix = DMat3::from_rotation_x(std::f64::consts::FRAC_PI_2) * 0.5;
        let world_from_camera = DAffine3 { matrix3: matrix.inverse(), translation: 5.0 * DVec3::Z };
        let vectors = [[1.0, 0.0, 5.0], [0.0; 3]];
        let normals = [[0.0, 0.5, 0.0], [0.0; 3]];
        let mut layers =
            [layer(Aov::Position, vectors), layer(Aov::Normal, normals), layer(Aov::Coc, normals)];
        to_camera(&mut layers, &world_from_camera.inverse());
        let near = |found: [f32; 3], expected: [f32; 3]| {
            (0..3).all(|i| (found[i] - expected[i]).abs() < 1e-6)
        };
        assert!(near(first(&layers[0]), [0.5, 0.0, 0.0]), "{:?}", first(&layers[0]));
        assert!(near(first(&layers[1]), [0.0, 0.0, 0.5]), "{:?}", first(&layers[1]));
        assert_eq!(layers[2], layer(Aov::Coc, normals));
        assert!(layers.iter().all(|layer| layer.channels.iter().all(|(_, v)| v[1] == 0.0)));
    }

    #[test]
    fn only_the_named_layers_change_their_space() {
        let mut layers = [layer(Aov::Albedo, [[0.5; 3]; 2]), layer(Aov::Normal, [[0.5; 3]; 2])];
        convert_colours(&mut layers, &["albedo"], &DMat3::from_diagonal(DVec3::new(1.0, 2.0, 0.5)));
        assert_eq!(first(&layers[0]), [0.5, 1.0, 0.25]);
        assert_eq!(layers[1], layer(Aov::Normal, [[0.5; 3]; 2]));
    }
}
