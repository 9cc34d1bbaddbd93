// Moving-bed shaft heater, axisymmetric (r, z) in m, radius 0.1, height 1: bed with axis, wall, bottom and top. Made for contbed.
// The gas enters through the bottom, where the temperatures of gas and silica part: cells of 7 mm there, 43 mm at the top.
// On the wall the gas slows down within a millimetre: cells of 0.7 mm there, 20 mm on the axis.
SetFactory("Built-in");
radius = 0.1;
height = 1.0;
across = 14;
along = 50;

Point(1) = {0, 0, 0};
Point(2) = {radius, 0, 0};
Point(3) = {radius, height, 0};
Point(4) = {0, height, 0};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};

// the top cell is 1.038^(along - 1) times the bottom one
// the cell on the axis is 1.3^(across - 1) times that on the wall
Transfinite Curve {-1, 3} = across + 1 Using Progression 1.3;
Transfinite Curve {2, -4} = along + 1 Using Progression 1.038;
Transfinite Surface {1} AlternateLeft;

Physical Curve("bottom", 1) = {1};
Physical Curve("wall", 2) = {2};
Physical Curve("top", 3) = {3};
Physical Curve("axis", 4) = {4};
Physical Surface("bed", 5) = {1};
