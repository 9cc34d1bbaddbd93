// Planar bed of two layers in m, 0.2 x 0.05 each: regions lower and upper, boundaries left, right, bottom and top. Made for contbed.
SetFactory("Built-in");
length = 0.2;
layer = 0.05;
size = 0.01;

Point(1) = {0, 0, 0, size};
Point(2) = {length, 0, 0, size};
Point(3) = {length, layer, 0, size};
Point(4) = {0, layer, 0, size};
Point(5) = {length, 2 * layer, 0, size};
Point(6) = {0, 2 * layer, 0, size};
Line(1) = {1, 2};
Line(2) = {2, 3};
Line(3) = {3, 4};
Line(4) = {4, 1};
Line(5) = {3, 5};
Line(6) = {5, 6};
Line(7) = {6, 4};
Curve Loop(1) = {1, 2, 3, 4};
Curve Loop(2) = {-3, 5, 6, 7};
Plane Surface(1) = {1};
Plane Surface(2) = {2};

Physical Curve("bottom", 1) = {1};
Physical Curve("right", 2) = {2, 5};
Physical Curve("top", 3) = {6};
Physical Curve("left", 4) = {4, 7};
Physical Surface("lower", 5) = {1};
Physical Surface("upper", 6) = {2};
