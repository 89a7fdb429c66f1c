"""Persons from a 2D laser scan alone: the baseline of paper 002, tables 1 and 2.

scan -> segments -> fourteen features -> classifier -> legs -> persons
"""
