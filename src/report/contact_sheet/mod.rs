//! Contact sheets: thumbnails of a sweep's pictures side by side.
//!
//! With two options, the first changes downwards and the second to the right, and their values are
//! along the edges. With one option, or more than two, pictures flow in rows, each above its
//! values. All pictures have the same exposure. The size of a sheet is bounded; it states how many
//! pictures it leaves out.

mod layout;
mod thumbnail;

use petzval_image::{DisplayExposure, Picture};

use super::svg::{Sheet, picture as drawing, shortened, width};
use layout::{Layout, TYPE};
use thumbnail::thumbnail;

/// Colours of the background, of empty frames and of text: a neutral surround.
const BACKGROUND: &str = "#262626";
const FRAME: &str = "#303030";
const TEXT: &str = "#e0e0e0";
/// Bytes per pixel of linear light. Thumbnails count twice, as automatic exposure copies them.
const LINEAR_BYTES: u64 = 12;
/// Bytes per pixel of the drawn sheet: RGBA, 8-bit codes, and the encoded file.
const DRAWN_BYTES: u64 = 4 + 7;
/// Largest width of the text at the left edge [px].
const MAX_MARGIN: f64 = 180.0;

/// One option that changes from picture to picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SheetAxis {
    /// Name of the option.
    pub name: String,
    /// Values of the option, in order.
    pub values: Vec<String>,
}

/// A contact sheet that pictures are added to.
#[derive(Clone, Debug)]
pub struct ContactSheet {
    title: String,
    axes: Vec<SheetAxis>,
    layout: Layout,
    /// Thumbnails by place on the sheet, in linear light.
    thumbnails: Vec<Option<Picture>>,
}

impl ContactSheet {
    /// Creates an empty sheet for pictures of about this width and height (pixels). The last axis
    /// changes fastest in the numbers of pictures.
    pub fn new(title: String, axes: Vec<SheetAxis>, size: [u32; 2]) -> Self {
        let counts: Vec<usize> = axes.iter().map(|axis| axis.values.len()).collect();
        let edge = axes.first().map_or(0.0, margin);
        let layout = Layout::new(&counts, size.map(f64::from), edge);
        let thumbnails = vec![None; layout.grid.iter().product()];
        Self { title, axes, layout, thumbnails }
    }

    /// Returns the largest memory use while the sheet is drawn and written (bytes).
    pub fn bytes(&self) -> u64 {
        let of = |[width, height]: [usize; 2]| (width * height) as u64;
        let [small, sheet] =
            [self.thumbnails.len() as u64 * of(self.layout.cell), of(self.layout.sheet)];
        LINEAR_BYTES * (2 * small + sheet) + DRAWN_BYTES * sheet
    }

    /// Returns whether a picture has a place on the sheet.
    pub fn shows(&self, number: usize) -> bool {
        self.layout.place(number).is_some()
    }

    /// Puts a picture into its place, if it has one.
    pub fn put(&mut self, number: usize, picture: &Picture) {
        if let Some(place) = self.layout.place(number) {
            self.thumbnails[place] = Some(thumbnail(picture, self.layout.cell));
        }
    }

    /// Removes a picture from its place.
    pub fn remove(&mut self, number: usize) {
        if let Some(place) = self.layout.place(number) {
            self.thumbnails[place] = None;
        }
    }

    /// Draws the sheet with all pictures at one exposure, in linear light, 1 for white.
    ///
    /// # Errors
    /// Returns an error if the text cannot be rasterised.
    pub fn draw(&self, exposure: DisplayExposure) -> Result<Picture, Box<dyn std::error::Error>> {
        let mut sheet = drawing(&self.svg())?;
        let factor = self.factor(exposure);
        for (place, small) in self.thumbnails.iter().enumerate() {
            let Some(small) = small else { continue };
            let [x, y] = self.layout.corner(place);
            let [left, top] =
                [(x, 0), (y, 1)].map(|(at, i)| at + (self.layout.cell[i] - small.size[i]) / 2);
            for (row, line) in small.pixels.chunks(small.size[0]).enumerate() {
                let first = (top + row) * sheet.size[0] + left;
                for (pixel, light) in sheet.pixels[first..].iter_mut().zip(line) {
                    *pixel = light.map(|light| (light * factor).clamp(0.0, 1.0));
                }
            }
        }
        Ok(sheet)
    }

    /// Returns the exposure factor of all pictures.
    fn factor(&self, exposure: DisplayExposure) -> f32 {
        if exposure != DisplayExposure::Auto {
            return exposure.factor(&Picture::default());
        }
        let pixels: Vec<[f32; 3]> = self
            .thumbnails
            .iter()
            .flatten()
            .flat_map(|small| small.pixels.iter().copied())
            .collect();
        exposure.factor(&Picture { size: [pixels.len(), 1], pixels })
    }

    /// Returns the sheet without the pictures as a drawing.
    fn svg(&self) -> String {
        let Layout { sheet: size, cell, .. } = self.layout;
        let mut sheet = Sheet::default();
        let wide = size.map(|n| n as f64);
        let corners = [[0.0, 0.0], [wide[0], 0.0], wide, [0.0, wide[1]]];
        sheet.path(&corners, true, &format!("fill=\"{BACKGROUND}\""));
        sheet.open(&format!("fill=\"{TEXT}\""));
        let [left, right] = [layout::GAP as f64, wide[0] - layout::GAP as f64];
        let mut line = |[x, y]: [f64; 2], size: f64, room: f64, words: &str| {
            sheet.text([x, y], size, "", &shortened(words, size, room));
        };
        line([left, 1.6 * TYPE], 1.2 * TYPE, right - left, &self.title);
        if let Some(left_out) = self.left_out() {
            line([left, wide[1] - 0.7 * TYPE], TYPE, right - left, &left_out);
        }
        let room = cell[0] as f64;
        if let [rows, columns] = &self.axes[..] {
            let [first, second] = self.layout.grid;
            for (row, value) in rows.values.iter().enumerate().take(first) {
                let [x, y] = self.layout.corner(row * second);
                let middle = y as f64 + cell[1] as f64 / 2.0;
                let room = x as f64 - 2.0 * left;
                line([left, middle - 0.2 * TYPE], TYPE, room, &rows.name);
                line([left, middle + 1.1 * TYPE], TYPE, room, value);
            }
            for (column, value) in columns.values.iter().enumerate().take(second) {
                let [x, y] = self.layout.corner(column);
                let words = format!("{} {value}", columns.name);
                line([x as f64, y as f64 - 0.5 * TYPE], TYPE, room, &words);
            }
        } else {
            for (place, number) in self.layout.numbers().enumerate() {
                let [x, y] = self.layout.corner(place).map(|v| v as f64);
                for (i, words) in self.labels(number).iter().enumerate() {
                    let below = y + cell[1] as f64 + (1.1 + 1.2 * i as f64) * TYPE;
                    line([x, below], TYPE, room, words);
                }
            }
        }
        sheet.close();
        for place in 0..self.layout.numbers().count() {
            let [x, y] = self.layout.corner(place).map(|v| v as f64);
            let [w, h] = cell.map(|n| n as f64);
            let frame = [[x, y], [x + w, y], [x + w, y + h], [x, y + h]];
            sheet.path(&frame, true, &format!("fill=\"{FRAME}\""));
        }
        sheet.finish(wide, &self.title)
    }

    /// Returns the lines below a picture, one for each option.
    fn labels(&self, number: usize) -> Vec<String> {
        let mut left = number;
        let mut labels: Vec<String> = Vec::new();
        for SheetAxis { name, values } in self.axes.iter().rev() {
            labels.push(format!("{name} {}", values[left % values.len()]));
            left /= values.len();
        }
        labels.reverse();
        labels
    }

    /// States how many pictures the sheet leaves out, if any.
    fn left_out(&self) -> Option<String> {
        let all: usize = self.axes.iter().map(|axis| axis.values.len()).product();
        let shown = self.layout.numbers().count();
        (shown < all).then(|| format!("{shown} of {all} pictures; there is no room for the others"))
    }
}

/// Returns the width of the text at the left edge [px].
fn margin(axis: &SheetAxis) -> f64 {
    let words = axis.values.iter().chain([&axis.name]);
    words.map(|words| width(words, TYPE)).fold(0.0, f64::max).min(MAX_MARGIN)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(name: &str, values: &[&str]) -> SheetAxis {
        SheetAxis { name: name.into(), values: values.iter().map(|&value| value.into()).collect() }
    }

    fn grey(light: f32) -> Picture {
        Picture { size: [30, 20], pixels: vec![[light; 3]; 600] }
    }

    /// Returns the value in the middle of a picture's place.
    fn middle(contact: &ContactSheet, drawn: &Picture, place: usize) -> f32 {
        let Layout { cell, .. } = contact.layout;
        let [x, y] = contact.layout.corner(place);
        drawn.pixels[(y + cell[1] / 2) * drawn.size[0] + x + cell[0] / 2][0]
    }

    #[test]
    fn pictures_are_in_their_places_with_one_exposure() {
        let axes = vec![axis("fstop", &["2", "4"]), axis("focus", &["1", "2", "3"])];
        let mut contact = ContactSheet::new("a".into(), axes, [30, 20]);
        for (number, light) in [(0, 0.1), (4, 0.2), (5, 0.4)] {
            contact.put(number, &grey(light));
        }
        let sheet = contact.draw(DisplayExposure::Stops(1.0)).expect("a sheet");
        let empty = middle(&contact, &sheet, 1);
        let found = [0, 1, 2, 3, 4, 5].map(|place| middle(&contact, &sheet, place));
        assert_eq!(found, [0.2, empty, empty, empty, 0.4, 0.8]);
        let words = contact.svg();
        assert_eq!(words.matches(">fstop<").count(), 2, "words at the edge are whole");
        let sheet = contact.draw(DisplayExposure::Auto).expect("a sheet");
        let found = [0, 4, 5].map(|place| middle(&contact, &sheet, place));
        assert_eq!(found, [0.25, 0.5, 1.0], "the brightest is white, and all are as they were");
    }

    #[test]
    fn labels_name_the_values() {
        let axes = ["a", "b", "c"].map(|name| axis(name, &["1", "2"]));
        let contact = ContactSheet::new("all".into(), axes.to_vec(), [30, 20]);
        assert_eq!(contact.labels(6), ["a 2", "b 2", "c 1"]);
        let words = contact.svg();
        assert_eq!(words.matches(">a 2<").count(), 4);
        assert!(words.contains("<title>all</title>") && contact.left_out().is_none());
        let many: Vec<String> = (0..100_000).map(|i| i.to_string()).collect();
        let axes = vec![SheetAxis { name: "seed".into(), values: many }];
        let contact = ContactSheet::new("all".into(), axes, [30, 20]);
        assert!(
            contact
                .left_out()
                .expect("most")
                .ends_with("of 100000 pictures; there is no room for the others")
        );
        assert!(contact.shows(0) && !contact.shows(99_999));
    }
}
