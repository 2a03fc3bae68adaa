//! Commands of OSLO that change no ray.

/// Designer, drawing, wavefront references, groups, solves and pickups (their values are stored),
/// notes, thermal data.
const COMMANDS: &[&str] = &[
    "DES", "DRW", "CBK", "LDP", "ELMDF1", "ELMDF2", "BDI", "BDD", "VX", "PF", "LMN", "LME", "LMO",
    "NOT", "SNO1", "SNO2", "SNO3", "SNO4", "SNO5", "TCE", "PFM", "PY", "PYC", "PU", "PUC", "EC",
    "PK", "TELE", "APCK", "WRSP", "AMO", "AFO", "RFS", "IMS", "TEM", "PRE", "SDAD", "SDBE", "DLRS",
    "DLVA", "COA", "SLB", "APN", "SPL", "CSD", "TSD", "GSP", "GOR", "SASD", "SDIL", "GPRT",
];

/// Returns whether a command changes no ray.
pub(super) fn changes_no_ray(keyword: &str) -> bool {
    COMMANDS.contains(&keyword)
}
