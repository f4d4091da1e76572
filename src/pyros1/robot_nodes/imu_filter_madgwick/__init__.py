"""imu_filter_madgwick: the orientation of an IMU by Madgwick's filter (https://wiki.ros.org/imu_filter_madgwick)."""
