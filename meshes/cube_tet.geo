// Unit cube in m of tetrahedra; bed between left, right (x), front, back (y), bottom and top (z). Made for contbed's tests.
SetFactory("Built-in");
size = 0.25;

Point(1) = {0, 0, 0, size};
Point(2) = {1, 0, 0, size};
Point(3) = {1, 1, 0, size};
Point(4) = {0, 1, 0, size};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Curve Loop(1) = {1, 2, 3, 4};
Plane Surface(1) = {1};
// the volume, the top and the sides over the curves 1 to 4
sides[] = Extrude {0, 0, 1} { Surface{1}; };

Physical Surface("bottom", 1) = {1};
Physical Surface("top", 2) = {sides[0]};
Physical Surface("front", 3) = {sides[2]};
Physical Surface("right", 4) = {sides[3]};
Physical Surface("back", 5) = {sides[4]};
Physical Surface("left", 6) = {sides[5]};
Physical Volume("bed", 7) = {sides[1]};
