//! Commands of CODE V that change no ray.

/// Title data, weights and vignetting factors of fields, variables and their limits, solves (their
/// values are stored), labels, coatings, drawing, tolerances, analyses.
const COMMANDS: &[&str] = &[
    "LEN", "INI", "TEM", "PRE", "WTF", "VUX", "VLX", "VUY", "VLY", "WID", "CA", "GO", "INS", "DER",
    "POL", "PIM", "CCY", "CCX", "THC", "GLC", "KC", "AC", "BC", "CC", "DC", "EC", "FC", "GC", "HC",
    "JC", "XDC", "YDC", "ZDC", "ADC", "BDC", "CDC", "SLB", "HMY", "UMY", "HCY", "UCY", "MLT",
    "CWL", "COA", "CUM", "SPH", "CON", "ASP", "CUF", "SPS", "END", "DES", "SAV", "EXI", "OUT",
    "WRI", "RSI", "TOW", "RAY", "CVO", "SD", "FTG", "PIK", "DEL", "DSP", "ARO", "IC", "CCM", "TCE",
    "FRZ", "VIE", "ZWL", "RDC", "INF", "COM", "MNT", "MNE", "MXT", "EFT", "EFY", "SCO", "STP",
    "XFO",
];

/// Returns whether a command changes no ray.
pub(super) fn changes_no_ray(keyword: &str) -> bool {
    COMMANDS.contains(&keyword)
}
