"""Prepares data for the page's panels: forms, parameters, goals, joints and launches; publishes at a rate."""
