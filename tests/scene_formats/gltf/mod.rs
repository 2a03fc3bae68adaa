//! Scenes in glTF: documents, buffers, materials, lights and cameras. The documents are written
//! here; their pictures have known values.

mod files;
mod lights;
mod materials;
mod specular;
mod view;

use std::path::Path;

use crate::support::{folder, petzval};
use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use image::{ImageBuffer, ImageFormat, Rgba};
use petzval::Picture;
use petzval_scene::{Geometry, Mesh};
use petzval_scene_formats::read;
use serde_json::{Value, json};

/// A document under construction, whose data are in one buffer.
struct Builder {
    json: Value,
    data: Vec<u8>,
}

impl Builder {
    /// Returns a document with a camera at z = 2 that looks along -z and sees the
    /// square from -1 to 1 in the plane z = 0.
    fn new() -> Self {
        let yfov = 2.0 * 0.5f64.atan();
        let json = json!({
            "asset": { "version": "2.0" },
            "scene": 0,
            "scenes": [{ "nodes": [0] }],
            "nodes": [{ "camera": 0, "translation": [0, 0, 2] }],
            "cameras": [{
                "type": "perspective",
                "perspective": { "yfov": yfov, "aspectRatio": 1, "znear": 0.01 },
            }],
            "buffers": [], "bufferViews": [], "accessors": [], "meshes": [], "materials": [],
            "images": [], "textures": [], "samplers": [],
        });
        Self { json, data: Vec::new() }
    }

    /// Appends a value to a list, and returns its index.
    fn push(&mut self, list: &str, value: Value) -> usize {
        let list = self.json[list].as_array_mut().expect("a list");
        list.push(value);
        list.len() - 1
    }

    /// Appends a node to the scene.
    fn node(&mut self, value: Value) {
        let index = self.push("nodes", value);
        self.json["scenes"][0]["nodes"].as_array_mut().expect("nodes").push(json!(index));
    }

    fn view(&mut self, bytes: &[u8]) -> usize {
        self.data.resize(self.data.len().next_multiple_of(4), 0);
        let offset = self.data.len();
        self.data.extend_from_slice(bytes);
        let view = json!({ "buffer": 0, "byteOffset": offset, "byteLength": bytes.len() });
        self.push("bufferViews", view)
    }

    fn vectors<const N: usize>(&mut self, vectors: &[[f32; N]]) -> usize {
        let bytes: Vec<u8> = vectors.iter().flatten().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let kind = ["SCALAR", "VEC2", "VEC3", "VEC4"][N - 1];
        let count = vectors.len();
        let accessor =
            json!({ "bufferView": view, "componentType": 5126, "count": count, "type": kind });
        self.push("accessors", accessor)
    }

    fn indices(&mut self, indices: &[u16]) -> usize {
        let bytes: Vec<u8> = indices.iter().flat_map(|v| v.to_le_bytes()).collect();
        let view = self.view(&bytes);
        let count = indices.len();
        let accessor =
            json!({ "bufferView": view, "componentType": 5123, "count": count, "type": "SCALAR" });
        self.push("accessors", accessor)
    }

    /// Adds the mesh of a square from -1 to 1 in the plane z = 0 that faces +z, upright in its image.
    fn square(&mut self, material: Value) -> usize {
        self.square_with(material, [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]])
    }

    /// As [`Self::square`], with the texture coordinates of the lower left, the lower right, the
    /// upper right and the upper left corner.
    fn square_with(&mut self, material: Value, uvs: [[f32; 2]; 4]) -> usize {
        let material = self.push("materials", material);
        let positions =
            self.vectors(&[[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]]);
        let normals = self.vectors(&[[0.0, 0.0, 1.0]; 4]);
        let uvs = self.vectors(&uvs);
        let indices = self.indices(&[0, 1, 2, 0, 2, 3]);
        let attributes = json!({ "POSITION": positions, "NORMAL": normals, "TEXCOORD_0": uvs });
        let primitive =
            json!({ "attributes": attributes, "indices": indices, "material": material });
        self.push("meshes", json!({ "primitives": [primitive] }))
    }

    /// Adds a texture of blocks of 16 x 16 pixels, row by row from the top, and returns its index.
    fn texture(&mut self, size: [u32; 2], pixels: &[[u8; 4]]) -> usize {
        let block = |x, y| Rgba(pixels[(y / 16 * size[0] + x / 16) as usize]);
        let image: ImageBuffer<Rgba<u8>, _> =
            ImageBuffer::from_fn(16 * size[0], 16 * size[1], block);
        let mut png = std::io::Cursor::new(Vec::new());
        image.write_to(&mut png, ImageFormat::Png).expect("a PNG");
        let view = self.view(png.get_ref());
        let source = self.push("images", json!({ "bufferView": view, "mimeType": "image/png" }));
        self.push("textures", json!({ "source": source }))
    }

    /// Adds lights of KHR_lights_punctual, each with its node.
    fn light(&mut self, light: Value, mut node: Value) {
        let lights = &mut self.json["extensions"]["KHR_lights_punctual"]["lights"];
        if lights.is_null() {
            *lights = json!([]);
        }
        let lights = lights.as_array_mut().expect("lights");
        lights.push(light);
        node["extensions"] = json!({ "KHR_lights_punctual": { "light": lights.len() - 1 } });
        self.node(node);
    }

    /// Returns the text of the document, with its data in it.
    fn text(&self) -> String {
        let uri = format!("data:application/octet-stream;base64,{}", STANDARD.encode(&self.data));
        self.text_with(json!({ "byteLength": self.data.len(), "uri": uri }))
    }

    fn text_with(&self, buffer: Value) -> String {
        let mut json = self.json.clone();
        json["buffers"] = json!([buffer]);
        serde_json::to_string_pretty(&json).expect("a text")
    }

    /// Returns the document as a binary file.
    fn glb(&self) -> Vec<u8> {
        let text = self.text_with(json!({ "byteLength": self.data.len() }));
        let mut glb = b"glTF\x02\0\0\0\0\0\0\0".to_vec();
        for (kind, content, filler) in
            [(b"JSON", text.as_bytes(), b' '), (b"BIN\0", &self.data[..], 0)]
        {
            let mut content = content.to_vec();
            content.resize(content.len().next_multiple_of(4), filler);
            glb.extend((content.len() as u32).to_le_bytes());
            glb.extend(kind);
            glb.extend(content);
        }
        let length = glb.len() as u32;
        glb[8..12].copy_from_slice(&length.to_le_bytes());
        glb
    }

    /// Renders the document with 64 x 64 pixels, and returns the picture and the messages.
    fn render(&self, options: &[&str]) -> (Picture, String) {
        self.render_whole(&[&["--resolution", "64x64"], options].concat())
    }

    /// Renders the document in its own size.
    fn render_whole(&self, options: &[&str]) -> (Picture, String) {
        let folder = folder();
        std::fs::write(folder.path().join("a.gltf"), self.text()).expect("a file");
        render(folder.path(), "a.gltf", options)
    }
}

fn render(folder: &Path, scene: &str, options: &[&str]) -> (Picture, String) {
    let all = [&["render", scene, "-o", "a.exr"], options].concat();
    let (code, _, said) = petzval(folder, &all);
    assert_eq!(code, 0, "{said}");
    (Picture::read(&folder.join("a.exr")).expect("a picture"), said)
}

/// Returns the mean of a part of a picture, from one pixel to another.
fn mean(picture: &Picture, from: [usize; 2], to: [usize; 2]) -> [f32; 3] {
    let mut sum = [0.0f64; 3];
    for y in from[1]..to[1] {
        for x in from[0]..to[0] {
            let pixel = picture.pixels[y * picture.size[0] + x];
            (0..3).for_each(|c| sum[c] += f64::from(pixel[c]));
        }
    }
    let count = ((to[0] - from[0]) * (to[1] - from[1])) as f64;
    sum.map(|s| (s / count) as f32)
}

/// Returns the mean of the middle of a picture of 64 x 64 pixels.
fn middle(picture: &Picture) -> [f32; 3] {
    mean(picture, [24, 24], [40, 40])
}

/// Returns the meshes of a document.
fn meshes(folder: &Path, name: &str) -> Vec<Mesh> {
    let description = read(&folder.join(name)).unwrap_or_else(|error| panic!("{error}"));
    let mesh = |geometry: &Geometry| match geometry {
        Geometry::Mesh(mesh) => mesh.clone(),
        other => panic!("{other:?}"),
    };
    description.scene.shapes.iter().map(|shape| mesh(&shape.geometry)).collect()
}
