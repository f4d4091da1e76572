"""imu_filter_madgwick: estimates an IMU's orientation with Madgwick's filter (https://wiki.ros.org/imu_filter_madgwick)."""
