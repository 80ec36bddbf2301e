// SPDX-License-Identifier: Apache-2.0
// Lays out two parts of each of the demo's pictures side by side, every pixel eight screen pixels wide. Rendered
// in the folder that holds the pictures, at 1824x1096: one unit is a pixel of the result, origin at the top left.
// Declare=Left_1=, Upper_1=, Left_2= and Upper_2= say which pixels the two parts begin with.
#version 3.7;
global_settings { assumed_gamma 1.0 }
background { rgb .04 }
camera {
  orthographic
  location <912, -548, -1000>
  look_at <912, -548, 0>
  right x * 1824
  up y * 1096
}

#declare kZoom = 8;

// 74 x Rows pixels of a picture, from its pixel (Left, Top), with their top left corner at (X, Y).
#macro Part(File, Left, Top, Rows, X, Y)
  box {
    <0, 0, 0>, <74 * kZoom, -Rows * kZoom, 1>
    pigment {
      image_map { png File once }
      scale <400, 225, 1> * <kZoom, kZoom, 1>
      translate <-Left * kZoom, (Top - 225) * kZoom, 0>
    }
    finish { ambient 0 diffuse 0 emission 1 }
    translate <X, Y, 0>
  }
#end

// Two parts of one picture, with its title, at a place in the grid of three by two.
#macro View(File, Title, Column, Row)
  #local X = 8 + Column * 608;
  #local Y = -34 - Row * 548;
  Part(File, Left_1, Upper_1, 36, X, Y)
  Part(File, Left_2, Upper_2, 27, X, Y - 36 * kZoom)
  text {
    internal 2 Title 1, 0
    scale <21, 21, 1>
    translate <X, Y + 9, 0>
    pigment { rgb .8 }
    finish { ambient 0 diffuse 0 emission 1 }
  }
#end

View("truth-pixels.png", "ground truth, averaged to pixels", 0, 0)
View("control.png", "control: one sample a pixel", 1, 0)
View("box.png", "box: three samples averaged", 2, 0)
View("subpixel.png", "a sample for each subpixel", 0, 1)
View("clipped.png", "Platt 2000, clipped", 1, 1)
View("optimum.png", "platt: the best within 0 ... 1", 2, 1)
