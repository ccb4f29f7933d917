"""A calibration file as others write it."""

# As the cameracalibrator of ROS' image_pipeline writes it: numbers padded to columns, zeros
# without digits after the point, exponents without a point before.
OF_ROS = """image_width: 640
image_height: 480
camera_name: narrow_stereo
camera_matrix:
  rows: 3
  cols: 3
  data: [504.10382,   0.     , 321.80917,
           0.     , 505.91447, 240.34672,
           0.     ,   0.     ,   1.     ]
distortion_model: plumb_bob
distortion_coefficients:
  rows: 1
  cols: 5
  data: [0.176832, -0.313041, 1e-05, -0.000812, 0.000000]
rectification_matrix:
  rows: 3
  cols: 3
  data: [1., 0., 0.,
         0., 1., 0.,
         0., 0., 1.]
projection_matrix:
  rows: 3
  cols: 4
  data: [517.82166,   0.     , 320.93245,   0.     ,
           0.     , 521.45001, 240.00123,   0.     ,
           0.     ,   0.     ,   1.     ,   0.     ]
"""
