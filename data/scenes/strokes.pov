// SPDX-License-Identifier: Apache-2.0
// Bright strokes, lines thinner than a pixel, shapes and letters on black: what shows best how a picture was
// sampled. Flat and self-lit, so that every value is in [0, 1] and a coverage is a value.
//
// Lengths are in pixels of a 400x225 picture, origin in the middle, y upwards. The view does not depend on the
// size rendered: 400x225 is the picture for a display, 1200x225 the same with three columns a pixel.
#version 3.7;
global_settings { assumed_gamma 1.0 }
background { rgb 0 }
camera {
  orthographic
  location <0, 0, -1000>
  look_at <0, 0, 0>
  right x * 16/9 * 225
  up y * 225
}

#declare kPaper = <1, 1, 1>;
#declare kRed = <1, .08, .05>;
#declare kAmber = <1, .55, .04>;
#declare kGreen = <.1, .9, .2>;
#declare kCyan = <.06, .8, 1>;
#declare kBlue = <.15, .25, 1>;
#declare kViolet = <.75, .2, 1>;

#macro Light(Colour)
  pigment { rgb Colour }
  finish { ambient 0 diffuse 0 emission 1 }
#end

// A stroke of constant width between two points.
#macro Stroke(X0, Y0, X1, Y1, Width, Colour)
  #local Length = sqrt(pow(X1 - X0, 2) + pow(Y1 - Y0, 2));
  box {
    <0, -Width / 2, -.5>, <Length, Width / 2, .5>
    rotate z * degrees(atan2(Y1 - Y0, X1 - X0))
    translate <X0, Y0, 0>
    Light(Colour)
  }
#end

// A fan: strokes at 48 angles that end before they would merge, half a pixel to nearly one and a half wide.
#declare kFan = <-128, 40, 0>;
#for (I, 0, 47)
  #local Angle = radians(I * 7.5 + 1.7);
  #local Inner = 14 + 6 * mod(I, 2);
  Stroke(kFan.x + Inner * cos(Angle), kFan.y + Inner * sin(Angle),
         kFan.x + 62 * cos(Angle), kFan.y + 62 * sin(Angle), .5 + .3 * mod(I, 4), kPaper)
#end

// Lines nearly upright, each thinner than the one before: 2 down to 1/8 of a pixel.
#for (I, 0, 12)
  Stroke(-46 + I * 6.37, -12, -42 + I * 6.37, 100, 2 * pow(1/16, I / 12), kPaper)
#end

// Lines nearly level, in colours, two thirds of a pixel wide.
#local Colours = array[6] {kRed, kAmber, kGreen, kCyan, kBlue, kViolet}
#for (I, 0, 11)
  Stroke(46, 96 - I * 5.3, 190, 101 - I * 5.3 - .35 * I, .66, Colours[mod(I, 6)])
#end

// Rings about one pixel thick, and discs.
#for (I, 0, 4)
  difference {
    cylinder { -.5 * z, .5 * z, 6 + 6 * I }
    cylinder { -z, z, 6 + 6 * I - (.5 + .25 * I) }
    translate <158, -8, 0>
    Light(kPaper)
  }
#end
#for (I, 0, 5)
  cylinder { -.5 * z, .5 * z, 7 - I translate <60 + 11.3 * I, 12 - 1.7 * I, -I> Light(Colours[I]) }
#end

// A square, a triangle and a star, turned so that no side is upright.
box { <-11, -11, -.5>, <11, 11, .5> rotate 12 * z translate <66, -22, 0> Light(kPaper) }
prism { linear_spline -.5, .5, 4, <0, 13>, <-12, -8>, <12, -8>, <0, 13> rotate -90 * x rotate 20 * z
  translate <99, -24, 0> Light(kAmber) }

// Letters: what most subpixels are used for.
#macro Words(Text, Size, X, Y, Colour)
  text { internal 2 Text 1, 0 scale <Size, Size, 1> translate <X, Y, 0> Light(Colour) }
#end
Words("Every stroke is a bargain with the grid", 10, -186, -52, kPaper)
Words("The quick brown fox jumps over the lazy dog 0123456789", 7.5, -186, -66, kPaper)
Words("thin lines, small letters, and what a pixel can carry", 6, -186, -77, kCyan)

// A sweep: upright bars, six pixels apart at first, then ever closer, to less than pixels can carry.
#declare X = -186;
#declare Pitch = 6;
#while (X < 40)
  box { <X, -104, -.5>, <X + Pitch / 2, -86, .5> Light(kPaper) }
  #declare X = X + Pitch;
  #declare Pitch = max(1.2, Pitch * .965);
#end

// A tangle of strokes at angles of no pattern, each in front of the one before.
#declare Chance = seed(1997);
#for (I, 0, 33)
  #local X0 = 50 + 138 * rand(Chance);
  #local Y0 = -104 + 52 * rand(Chance);
  #local Angle = 2 * pi * rand(Chance);
  #local Reach = 8 + 22 * rand(Chance);
  #local Colour = kPaper;
  #if (mod(I, 3) = 0)
    #local Colour = Colours[mod(I / 3, 6)];
  #end
  #local X1 = min(196, X0 + Reach * cos(Angle));
  #local Y1 = min(-50, max(-108, Y0 + Reach * sin(Angle)));
  object { Stroke(X0, Y0, X1, Y1, .4 + 1.2 * rand(Chance), Colour) translate -(10 + 2 * I) * z }
#end
