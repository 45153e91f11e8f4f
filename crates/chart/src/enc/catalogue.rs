//! Object classes of S-57 (edition 3.1, appendix A): code and acronym.

/// In the order of the codes.
#[rustfmt::skip]
const CLASSES: [(u16, &str); 179] = [
    (1, "ADMARE"), (2, "AIRARE"), (3, "ACHBRT"), (4, "ACHARE"), (5, "BCNCAR"), (6, "BCNISD"), (7, "BCNLAT"),
    (8, "BCNSAW"), (9, "BCNSPP"), (10, "BERTHS"), (11, "BRIDGE"), (12, "BUISGL"), (13, "BUAARE"),
    (14, "BOYCAR"), (15, "BOYINB"), (16, "BOYISD"), (17, "BOYLAT"), (18, "BOYSAW"), (19, "BOYSPP"),
    (20, "CBLARE"), (21, "CBLOHD"), (22, "CBLSUB"), (23, "CANALS"), (24, "CANBNK"), (25, "CTSARE"),
    (26, "CAUSWY"), (27, "CTNARE"), (28, "CHKPNT"), (29, "CGUSTA"), (30, "COALNE"), (31, "CONZNE"),
    (32, "COSARE"), (33, "CTRPNT"), (34, "CONVYR"), (35, "CRANES"), (36, "CURENT"), (37, "CUSZNE"),
    (38, "DAMCON"), (39, "DAYMAR"), (40, "DWRTCL"), (41, "DWRTPT"), (42, "DEPARE"), (43, "DEPCNT"),
    (44, "DISMAR"), (45, "DOCARE"), (46, "DRGARE"), (47, "DRYDOC"), (48, "DMPGRD"), (49, "DYKCON"),
    (50, "EXEZNE"), (51, "FAIRWY"), (52, "FNCLNE"), (53, "FERYRT"), (54, "FSHZNE"), (55, "FSHFAC"),
    (56, "FSHGRD"), (57, "FLODOC"), (58, "FOGSIG"), (59, "FORSTC"), (60, "FRPARE"), (61, "GATCON"),
    (62, "GRIDRN"), (63, "HRBARE"), (64, "HRBFAC"), (65, "HULKES"), (66, "ICEARE"), (67, "ICNARE"),
    (68, "ISTZNE"), (69, "LAKARE"), (70, "LAKSHR"), (71, "LNDARE"), (72, "LNDELV"), (73, "LNDRGN"),
    (74, "LNDMRK"), (75, "LIGHTS"), (76, "LITFLT"), (77, "LITVES"), (78, "LOCMAG"), (79, "LOKBSN"),
    (80, "LOGPON"), (81, "MAGVAR"), (82, "MARCUL"), (83, "MIPARE"), (84, "MORFAC"), (85, "NAVLNE"),
    (86, "OBSTRN"), (87, "OFSPLF"), (88, "OSPARE"), (89, "OILBAR"), (90, "PILPNT"), (91, "PILBOP"),
    (92, "PIPARE"), (93, "PIPOHD"), (94, "PIPSOL"), (95, "PONTON"), (96, "PRCARE"), (97, "PRDARE"),
    (98, "PYLONS"), (99, "RADLNE"), (100, "RADRNG"), (101, "RADRFL"), (102, "RADSTA"), (103, "RTPBCN"),
    (104, "RDOCAL"), (105, "RDOSTA"), (106, "RAILWY"), (107, "RAPIDS"), (108, "RCRTCL"), (109, "RECTRC"),
    (110, "RCTLPT"), (111, "RSCSTA"), (112, "RESARE"), (113, "RETRFL"), (114, "RIVERS"), (115, "RIVBNK"),
    (116, "ROADWY"), (117, "RUNWAY"), (118, "SNDWAV"), (119, "SEAARE"), (120, "SPLARE"), (121, "SBDARE"),
    (122, "SLCONS"), (123, "SISTAT"), (124, "SISTAW"), (125, "SILTNK"), (126, "SLOTOP"), (127, "SLOGRD"),
    (128, "SMCFAC"), (129, "SOUNDG"), (130, "SPRING"), (131, "SQUARE"), (132, "STSLNE"), (133, "SUBTLN"),
    (134, "SWPARE"), (135, "TESARE"), (136, "TS_PRH"), (137, "TS_PNH"), (138, "TS_PAD"), (139, "TS_TIS"),
    (140, "T_HMON"), (141, "T_NHMN"), (142, "T_TIMS"), (143, "TIDEWY"), (144, "TOPMAR"), (145, "TSELNE"),
    (146, "TSSBND"), (147, "TSSCRS"), (148, "TSSLPT"), (149, "TSSRON"), (150, "TSEZNE"), (151, "TUNNEL"),
    (152, "TWRTPT"), (153, "UWTROC"), (154, "UNSARE"), (155, "VEGATN"), (156, "WATTUR"), (157, "WATFAL"),
    (158, "WEDKLP"), (159, "WRECKS"), (160, "TS_FEB"), (161, "ARCSLN"), (162, "ASLXIS"), (163, "NEWOBJ"),
    (300, "M_ACCY"), (301, "M_CSCL"), (302, "M_COVR"), (303, "M_HDAT"), (304, "M_HOPA"), (305, "M_NPUB"),
    (306, "M_NSYS"), (307, "M_PROD"), (308, "M_QUAL"), (309, "M_SDAT"), (310, "M_SREL"), (311, "M_UNIT"),
    (312, "M_VDAT"), (400, "C_AGGR"), (401, "C_ASSO"), (402, "C_STAC"),
];

/// The acronym of a class; `None` for a code that the standard lacks.
pub fn class_name(code: u16) -> Option<&'static str> {
    CLASSES.binary_search_by_key(&code, |(own, _)| *own).ok().map(|k| CLASSES[k].1)
}

/// The code of a class; `None` for an acronym that the standard lacks.
pub fn class(acronym: &str) -> Option<u16> {
    CLASSES.iter().find(|(_, own)| *own == acronym).map(|(code, _)| *code)
}
