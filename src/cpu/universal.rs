//! Universal executable: the portable program, and behind it the program that needs AVX2.
//!
//! `wide` chooses instructions when it is compiled, and kernels are inlined into every stage, so the
//! whole program is compiled twice and not each kernel. The file is the portable executable, the AVX2
//! executable and a footer of [`FOOTER`] bytes: the length of the latter in 16 decimal digits, and
//! [`MARK`]. The system ignores what follows an executable. `.ci/universal` puts the file together.

use std::io::{self, Read, Seek, SeekFrom, Write};

/// End of a universal executable.
const MARK: &[u8; 16] = b"petzval-x86-64v3";
/// Bytes of the footer: 16 digits and the mark.
const FOOTER: usize = 32;

/// Returns whether the CPU, and the system, have all instructions of x86-64-v3.
pub fn has_avx2() -> bool {
    is_x86_feature_detected!("avx2")
        && is_x86_feature_detected!("fma")
        && is_x86_feature_detected!("bmi1")
        && is_x86_feature_detected!("bmi2")
        && is_x86_feature_detected!("f16c")
        && is_x86_feature_detected!("lzcnt")
        && is_x86_feature_detected!("movbe")
}

/// Replaces this process by the AVX2 program behind it. Returns if there is none.
///
/// # Errors
/// If the executable cannot be read, or the system refuses to run the program.
#[cfg(target_os = "linux")]
pub fn start() -> io::Result<()> {
    use std::fs::File;
    use std::os::fd::AsRawFd;
    use std::os::unix::process::CommandExt;
    use std::process::Command;

    use nix::sys::memfd::{MFdFlags, memfd_create};

    let mut own = File::open("/proc/self/exe")?;
    let Some(length) = program_length(&mut own)? else {
        return Ok(());
    };
    let mut image = File::from(memfd_create("petzval", MFdFlags::MFD_CLOEXEC)?);
    copy_program(&mut own, length, &mut image)?;
    let mut arguments = std::env::args_os();
    let name = arguments.next().unwrap_or_else(|| "petzval".into());
    // Returns only if it fails.
    let path = format!("/proc/self/fd/{}", image.as_raw_fd());
    Err(Command::new(path).arg0(name).args(arguments).exec())
}

/// Does nothing: only Linux runs a program from memory.
#[cfg(not(target_os = "linux"))]
pub fn start() -> io::Result<()> {
    Ok(())
}

/// Returns the length of the AVX2 program (bytes), or `None` if the file ends without [`MARK`].
fn program_length(file: &mut (impl Read + Seek)) -> io::Result<Option<u64>> {
    let end = file.seek(SeekFrom::End(0))?;
    if end < FOOTER as u64 {
        return Ok(None);
    }
    let mut footer = [0; FOOTER];
    file.seek(SeekFrom::End(-(FOOTER as i64)))?;
    file.read_exact(&mut footer)?;
    let (digits, mark) = footer.split_at(FOOTER - MARK.len());
    if mark != MARK {
        return Ok(None);
    }
    let length = std::str::from_utf8(digits).ok().and_then(|digits| digits.parse().ok());
    match length {
        Some(length) if length <= end - FOOTER as u64 => Ok(Some(length)),
        _ => Err(io::Error::new(
            io::ErrorKind::InvalidData,
            format!(
                "the executable's footer says '{}', which is not a length below its {end} bytes; \
                 make the file again with .ci/universal",
                String::from_utf8_lossy(digits)
            ),
        )),
    }
}

/// Copies the program of this length in front of the footer.
fn copy_program(from: &mut (impl Read + Seek), length: u64, to: &mut impl Write) -> io::Result<()> {
    from.seek(SeekFrom::End(-((length + FOOTER as u64) as i64)))?;
    let copied = io::copy(&mut from.take(length), to)?;
    if copied == length { Ok(()) } else { Err(io::ErrorKind::UnexpectedEof.into()) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn universal(program: &[u8], footer: &str) -> io::Cursor<Vec<u8>> {
        io::Cursor::new([b"portable", program, footer.as_bytes()].concat())
    }

    #[test]
    fn the_program_in_front_of_the_footer_is_found() {
        let mut file = universal(b"fast", "0000000000000004petzval-x86-64v3");
        assert_eq!(program_length(&mut file).unwrap(), Some(4));
        let mut copy = Vec::new();
        copy_program(&mut file, 4, &mut copy).unwrap();
        assert_eq!(copy, b"fast");
    }

    #[test]
    fn other_executables_have_none() {
        for footer in ["", "0000000000000004petzval-x86-64v4", "\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0\0"] {
            assert_eq!(program_length(&mut universal(b"fast", footer)).unwrap(), None, "{footer}");
        }
    }

    #[test]
    fn a_damaged_footer_is_an_error() {
        for digits in ["0000000000000100", "-000000000000004", "four            "] {
            let mut file = universal(b"fast", &format!("{digits}petzval-x86-64v3"));
            let error = program_length(&mut file).unwrap_err().to_string();
            assert!(error.contains(".ci/universal"), "{error}");
        }
    }
}
