//! Tests of the table of settings.

use super::*;
use crate::prepare::{Changes, FocusOn};

fn words(text: &str) -> SettingValue {
    SettingValue::Words(text.to_owned())
}

fn numbers(list: &[f64]) -> SettingValue {
    SettingValue::List(list.iter().map(|&number| SettingValue::Number(number)).collect())
}

#[test]
fn words_take_units() {
    let metres = |text: &str| match focus(&words(text)) {
        Ok(FocusOn::Distance(metres)) => metres,
        other => panic!("{text}: {other:?}"),
    };
    let found = ["2", "2m", "850mm", "inf", "2.5e-1m", "10ft"].map(metres);
    assert_eq!(found, [2.0, 2.0, 0.85, f64::INFINITY, 0.25, 3.048]);
    for bad in ["", "m", "-2m", "0mm", "nan", "nanmm", "infm", "2 m m", "2kg", "1e999m", "+-1"] {
        assert!(focus(&words(bad)).is_err() && film_diagonal(&words(bad)).is_err(), "{bad}");
    }
    for text in ["8", "f/8", "F8", "f8", "F/8.0"] {
        assert_eq!(f_number(&words(text)), Ok(8.0), "{text}");
    }
    for bad in ["f/", "f//8", "f/0", "ff8", "inf", "f/inf", "8mm"] {
        assert!(f_number(&words(bad)).is_err(), "{bad}");
    }
    assert_eq!(focus(&words("auto@3,4")), Ok(FocusOn::Pixel(Some([3, 4]))));
    assert!(focus(&words("auto@3")).is_err() && focus(&words("auto3,4")).is_err());
    assert_eq!(film_shift(&words("1mm,-0.2cm")), Ok([1.0, -2.0]));
    assert_eq!(film_tilt(&words("1deg,-2°")), Ok([1.0, -2.0]));
    assert_eq!(passband(&words("540nm..560nm")), passband(&numbers(&[540.0, 560.0])));
    assert!(time(&words("1/60s")).is_ok() && time(&words("1/60s")) == time(&words("1/60")));
}

#[test]
fn words_and_numbers_have_one_range() {
    // Values at the ends of each range, and beyond them.
    for (name, good, bad) in [
        ("fstop", &[0.1, 1e4][..], &[0.0, -2.0, f64::NAN, f64::INFINITY][..]),
        ("focus", &[0.1, f64::INFINITY], &[0.0, -1.0, f64::NAN]),
        ("film_diagonal", &[1e-3, 1e4], &[0.9e-3, 1.1e4, -1.0, f64::NAN]),
        ("noise", &[1e-5, 1.0], &[0.0, 1.1, f64::NAN]),
        ("time", &[1e-3, 1e9], &[0.0, -1.0, 1.1e9, f64::INFINITY, f64::NAN]),
        ("zoom", &[1.0, 1e3], &[0.0, -1.0, f64::INFINITY, f64::NAN]),
    ] {
        let setting = PictureSetting::named(name).expect("a setting");
        let read = |number: f64| {
            [words(&number.to_string()), SettingValue::Number(number)]
                .map(|value| setting.read(&value).map(|_| ()))
        };
        for &number in good {
            assert_eq!(read(number), [Ok(()), Ok(())], "{name} {number}");
        }
        for &number in bad {
            for read in read(number) {
                assert!(matches!(read, Err(SettingError::Value(_))), "{name} {number}: {read:?}");
            }
        }
    }
    for (name, good, bad) in [
        ("spp", &[1, 1 << 30][..], &[0, -1, (1 << 30) + 1][..]),
        ("seed", &[0, u32::MAX.into()], &[-1, 1 << 32]),
    ] {
        let setting = PictureSetting::named(name).expect("a setting");
        for (numbers, fits) in [(good, true), (bad, false)] {
            for &number in numbers {
                for value in [words(&number.to_string()), SettingValue::Whole(number)] {
                    assert_eq!(setting.read(&value).is_ok(), fits, "{name} {value}");
                }
            }
        }
    }
}

#[test]
fn another_type_is_told_from_an_unsound_value() {
    for setting in SETTINGS.iter() {
        let read = setting.read(&SettingValue::Other).map(|_| ());
        let Err(SettingError::Type(expected)) = read else { panic!("{}: {read:?}", setting.name) };
        assert!(expected.starts_with("expected "), "{}: {expected}", setting.name);
    }
    let text = SettingValue::Text("f/4".to_owned());
    assert!(matches!(f_number(&text), Err(SettingError::Type(_))));
    let size = |list: &[i64]| {
        resolution(&SettingValue::List(list.iter().map(|&n| SettingValue::Whole(n)).collect()))
    };
    assert_eq!(size(&[1, 65536]), Ok([1, 65536]));
    assert_eq!(size(&[1, 65536]), resolution(&words("1x65536")));
    for bad in [&[5][..], &[0, 1], &[1, 65537], &[1, 2, 3]] {
        assert!(matches!(size(bad), Err(SettingError::Value(_))), "{bad:?}");
    }
    assert!(matches!(resolution(&numbers(&[1.5, 2.0])), Err(SettingError::Type(_))));
}

#[test]
fn a_mosaic_implies_a_sensor_in_any_order() {
    let given = |name: &str, text: &str| {
        PictureSetting::named(name).expect("a setting").read(&words(text)).expect("a value")
    };
    let (sensor, bayer) = (given("sensor", "iso=800"), given("bayer", "bggr"));
    for both in [[&sensor, &bayer], [&bayer, &sensor]] {
        let sensor = Changes::of(both).sensor.expect("a sensor");
        assert_eq!((sensor.iso, sensor.bayer.map(|b| b.name())), (Some(800.0), Some("bggr")));
    }
    let alone = Changes::of([&bayer]).sensor.expect("a sensor");
    assert_eq!(alone.iso, None);
}

#[test]
fn a_viewpoint_is_words_or_lists() {
    let look_at = PictureSetting::named("look_at").expect("a setting");
    let points =
        |points: &[&[f64]]| SettingValue::List(points.iter().map(|p| numbers(p)).collect());
    let view = |value| Changes::of([&look_at.read(&value).expect("a viewpoint")]).viewpoint;
    let expected = view(words("0,1,-3,0,0.5,0"));
    assert_eq!(view(points(&[&[0.0, 1.0, -3.0], &[0.0, 0.5, 0.0]])), expected);
    assert_eq!(view(points(&[&[0.0, 1.0, -3.0], &[0.0, 0.5, 0.0], &[0.0, 1.0, 0.0]])), expected);
    for bad in [&[&[0.0; 3][..], &[0.0; 3]][..], &[&[0.0; 2], &[1.0; 3]], &[&[0.0; 3]]] {
        let read = look_at.read(&points(bad)).map(|_| ());
        assert!(matches!(read, Err(SettingError::Value(_))), "{bad:?}: {read:?}");
    }
}
