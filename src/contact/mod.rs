//! Contact sheets: the pictures of a sweep, small and side by side, as they change with what was
//! changed.
//!
//! One option, or more than two, flow in rows, each picture above its values; of two the first goes
//! down and the second to the right, with their values along the edges. All pictures are developed
//! alike. A sheet is bounded whatever it is of: what finds no room is counted on it.

mod layout;
mod thumbnail;

use crate::image::{Exposure, Picture};
use crate::svg::{Sheet, picture as drawing, shortened, width};
use layout::{Layout, TYPE};
use thumbnail::thumbnail;

/// The ground, frames of pictures that are not there yet, and words: a neutral surround.
const GROUND: &str = "#262626";
const EMPTY: &str = "#303030";
const WORDS: &str = "#e0e0e0";
/// Bytes of a pixel of light; all small pictures are there twice where they find their exposure.
const LIGHT: u64 = 12;
/// Bytes of a pixel of the sheet as it is drawn, as codes, and in its file before it is written.
const DRAWN: u64 = 4 + 7;
/// Words at the left edge, at most, px.
const WIDEST: f64 = 180.0;

/// One option that changes from picture to picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Axis {
    /// Its name.
    pub name: String,
    /// Its values, in order.
    pub values: Vec<String>,
}

/// A contact sheet in the making.
#[derive(Clone, Debug)]
pub struct Contact {
    title: String,
    axes: Vec<Axis>,
    layout: Layout,
    /// The pictures on the sheet, by their place there; linear light.
    small: Vec<Option<Picture>>,
}

impl Contact {
    /// An empty sheet for pictures of about this width and height, pixels. Pictures are numbered with
    /// the value of the last axis changing fastest.
    pub fn new(title: String, axes: Vec<Axis>, size: [u32; 2]) -> Self {
        let counts: Vec<usize> = axes.iter().map(|axis| axis.values.len()).collect();
        let edge = axes.first().map_or(0.0, margin);
        let layout = Layout::new(&counts, size.map(f64::from), edge);
        let small = vec![None; layout.grid.iter().product()];
        Self { title, axes, layout, small }
    }

    /// The bytes that it takes, at most, while it is drawn and written.
    pub fn bytes(&self) -> u64 {
        let of = |[width, height]: [usize; 2]| (width * height) as u64;
        let [small, sheet] =
            [self.small.len() as u64 * of(self.layout.cell), of(self.layout.sheet)];
        LIGHT * (2 * small + sheet) + DRAWN * sheet
    }

    /// Whether this picture has a place on the sheet.
    pub fn shows(&self, number: usize) -> bool {
        self.layout.place(number).is_some()
    }

    /// Puts a picture into its place, if it has one.
    pub fn put(&mut self, number: usize, picture: &Picture) {
        if let Some(place) = self.layout.place(number) {
            self.small[place] = Some(thumbnail(picture, self.layout.cell));
        }
    }

    /// Takes a picture out of its place.
    pub fn remove(&mut self, number: usize) {
        if let Some(place) = self.layout.place(number) {
            self.small[place] = None;
        }
    }

    /// The sheet, all pictures at one exposure; light, of which 1 is the white of a screen.
    ///
    /// # Errors
    /// Where its words cannot be drawn.
    pub fn draw(&self, exposure: Exposure) -> Result<Picture, Box<dyn std::error::Error>> {
        let mut sheet = drawing(&self.words())?;
        let factor = self.factor(exposure);
        for (place, small) in self.small.iter().enumerate() {
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

    /// What all pictures are multiplied by.
    fn factor(&self, exposure: Exposure) -> f32 {
        if exposure != Exposure::Auto {
            return exposure.factor(&Picture::default());
        }
        let pixels: Vec<[f32; 3]> =
            self.small.iter().flatten().flat_map(|small| small.pixels.iter().copied()).collect();
        exposure.factor(&Picture { size: [pixels.len(), 1], pixels })
    }

    /// All but the pictures, as a drawing.
    fn words(&self) -> String {
        let Layout { sheet: size, cell, .. } = self.layout;
        let mut sheet = Sheet::default();
        let wide = size.map(|n| n as f64);
        let corners = [[0.0, 0.0], [wide[0], 0.0], wide, [0.0, wide[1]]];
        sheet.path(&corners, true, &format!("fill=\"{GROUND}\""));
        sheet.open(&format!("fill=\"{WORDS}\""));
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
            sheet.path(&frame, true, &format!("fill=\"{EMPTY}\""));
        }
        sheet.finish(wide, &self.title)
    }

    /// What stands below a picture, a line an option.
    fn labels(&self, number: usize) -> Vec<String> {
        let mut left = number;
        let mut labels: Vec<String> = Vec::new();
        for Axis { name, values } in self.axes.iter().rev() {
            labels.push(format!("{name} {}", values[left % values.len()]));
            left /= values.len();
        }
        labels.reverse();
        labels
    }

    /// What finds no room, in words.
    fn left_out(&self) -> Option<String> {
        let all: usize = self.axes.iter().map(|axis| axis.values.len()).product();
        let shown = self.layout.numbers().count();
        (shown < all).then(|| format!("{shown} of {all} pictures; the others find no room here"))
    }
}

/// How wide the words at the left edge are, px.
fn margin(axis: &Axis) -> f64 {
    let words = axis.values.iter().chain([&axis.name]);
    words.map(|words| width(words, TYPE)).fold(0.0, f64::max).min(WIDEST)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn axis(name: &str, values: &[&str]) -> Axis {
        Axis { name: name.into(), values: values.iter().map(|&value| value.into()).collect() }
    }

    fn grey(light: f32) -> Picture {
        Picture { size: [30, 20], pixels: vec![[light; 3]; 600] }
    }

    /// The middle of a picture's place.
    fn middle(contact: &Contact, sheet: &Picture, place: usize) -> f32 {
        let Layout { cell, .. } = contact.layout;
        let [x, y] = contact.layout.corner(place);
        sheet.pixels[(y + cell[1] / 2) * sheet.size[0] + x + cell[0] / 2][0]
    }

    #[test]
    fn pictures_stand_in_their_places_and_are_developed_alike() {
        let axes = vec![axis("fstop", &["2", "4"]), axis("focus", &["1", "2", "3"])];
        let mut contact = Contact::new("a".into(), axes, [30, 20]);
        for (number, light) in [(0, 0.1), (4, 0.2), (5, 0.4)] {
            contact.put(number, &grey(light));
        }
        let sheet = contact.draw(Exposure::Stops(1.0)).expect("a sheet");
        let empty = middle(&contact, &sheet, 1);
        let found = [0, 1, 2, 3, 4, 5].map(|place| middle(&contact, &sheet, place));
        assert_eq!(found, [0.2, empty, empty, empty, 0.4, 0.8]);
        let words = contact.words();
        assert_eq!(words.matches(">fstop<").count(), 2, "words at the edge are whole");
        let sheet = contact.draw(Exposure::Auto).expect("a sheet");
        let found = [0, 4, 5].map(|place| middle(&contact, &sheet, place));
        assert_eq!(found, [0.25, 0.5, 1.0], "the brightest is white, and all are as they were");
    }

    #[test]
    fn words_say_what_has_changed() {
        let axes = ["a", "b", "c"].map(|name| axis(name, &["1", "2"]));
        let contact = Contact::new("all".into(), axes.to_vec(), [30, 20]);
        assert_eq!(contact.labels(6), ["a 2", "b 2", "c 1"]);
        let words = contact.words();
        assert_eq!(words.matches(">a 2<").count(), 4);
        assert!(words.contains("<title>all</title>") && contact.left_out().is_none());
        let many: Vec<String> = (0..100_000).map(|i| i.to_string()).collect();
        let axes = vec![Axis { name: "seed".into(), values: many }];
        let contact = Contact::new("all".into(), axes, [30, 20]);
        assert!(
            contact
                .left_out()
                .expect("most")
                .ends_with("of 100000 pictures; the others find no room here")
        );
        assert!(contact.shows(0) && !contact.shows(99_999));
    }
}
