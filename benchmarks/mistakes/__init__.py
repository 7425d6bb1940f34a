"""Are the mistakes people make found and named?"""
