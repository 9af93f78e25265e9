"""What the cases are from, and what they compare with."""

SOURCES = (
    "RiMEA e.V. 2025, Guideline for microscopic evacuation analyses, 4.1.1",
    "Ronchi, Kuligowski, Reneke, Peacock & Nilsson 2013, The process of"
    " verification and validation of building fire evacuation models, NIST"
    " Technical Note 1822",
    "ISO 20414:2020, Fire safety engineering: verification and validation"
    " protocol for building fire evacuation models",
    "Weidmann 1993, Transporttechnik der Fußgänger, ETH Zürich",
    "Seyfried, Passon, Steffen, Boltes, Rupprecht & Klingsch 2009, New insights"
    " into pedestrian flow through bottlenecks",
    "Helbing, Farkas & Vicsek 2000, Simulating dynamical features of escape"
    " panic",
    "Moussaïd, Perozo, Garnier, Helbing & Theraulaz 2010, The walking behaviour"
    " of pedestrian social groups and its impact on crowd dynamics",
    "Feliciani & Nishinari 2016, Empirical analysis of the lane formation"
    " process in bidirectional pedestrian flow",
)
