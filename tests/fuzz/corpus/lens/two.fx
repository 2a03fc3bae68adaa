[Metadata]
Name: Two lenses
[Surfaces]
Radius Thickness IOR Housing-Radius Abbe-No Material Geometry
40 6 1.6 10 60 UNKNOWN SPHERICAL
-60 2 1 10 0 AIR SPHERICAL
0 3 0 5 AIR PLANAR
-30 2 1.7 8 30 UNKNOWN SPHERICAL
-80 40 1 8 0 AIR SPHERICAL
[Aspheric Coefficients]
3: k=0 a2=1E-06 a4=2e-9
